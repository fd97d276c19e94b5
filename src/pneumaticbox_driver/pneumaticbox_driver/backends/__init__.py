"""Backends: the plant on topics, a simulated box in process, or real hardware."""
