"""The hand in PyBullet: its bodies, wrist, air and springs, from the hand's file to a step."""
