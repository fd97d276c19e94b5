"""Backends: what the box is connected to, topics, the embedded bench or real hardware."""
