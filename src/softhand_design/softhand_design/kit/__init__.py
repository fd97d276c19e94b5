"""All parts of a hand other than the moulds of its actuators, placed in the hand and checked
there."""
