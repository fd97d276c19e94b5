"""Benchmarks of robustness: what hostile input, faults and long runs do to the suite."""
