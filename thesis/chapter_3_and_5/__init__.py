"""Chapters 3 and 5: the finger and the hands in the simulator."""
