"""Bending of sections and fingers: the balance of elastic side and load."""
