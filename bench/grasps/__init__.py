"""Benchmarks of grasps: sweeps and maps."""
