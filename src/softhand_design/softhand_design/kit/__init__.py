"""All parts of a hand beside the moulds of its actuators, placed in the hand and checked there."""
