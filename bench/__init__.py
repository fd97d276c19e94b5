"""Benchmarks: `python -m bench [module ...]`, or `make bench` for all."""
