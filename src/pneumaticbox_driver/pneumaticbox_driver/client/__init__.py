"""A client of the driver, for scripts."""
