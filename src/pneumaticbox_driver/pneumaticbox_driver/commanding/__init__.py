"""Takes commands and valve schedules."""
