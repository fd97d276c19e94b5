"""Causes of the difference between a P5, the actuator of RBO Hand 1, and its model (7.2, 8.1.2)."""
