"""The series of measurements as a suspect: events between runs, odd runs, structure within runs."""
