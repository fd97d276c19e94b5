"""Calibration of equation 4.1: test pulses, their regression, and the file."""
