"""Publishes what the box knows at every sample."""
