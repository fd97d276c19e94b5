"""Faults in a series of measurements: events between runs, odd runs, and structure within runs."""
