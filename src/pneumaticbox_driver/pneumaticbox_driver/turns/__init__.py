"""Serves what comes in by turns, without an executor."""
