"""Measurement sets: in memory, read from CSV files and bags, checked, thinned, written."""
