"""Drawings of a design and of its mould."""
