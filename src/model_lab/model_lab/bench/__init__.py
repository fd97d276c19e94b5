"""Runs and sets before anything is measured: protocols, layouts, synthesised sets."""
