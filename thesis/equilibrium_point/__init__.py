"""Equilibrium-point control on the simulated finger: what a push does under each controller."""
