"""Numerics that the physics shares: compiled kernels and rotations."""
