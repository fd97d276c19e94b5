"""Grasp strategies as data, the sequencer that runs them, and its node."""
