"""Judges a grasp: its verdict, why it failed, and when nothing can change that any more."""
