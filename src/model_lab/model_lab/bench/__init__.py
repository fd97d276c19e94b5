"""Planned runs and sets: protocols, layouts, and synthesised sets."""
