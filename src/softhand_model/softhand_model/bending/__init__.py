"""Bending of sections and fingers: the balance of elastic stress and load."""
