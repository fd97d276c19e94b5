"""The names on top of `model_lab`, and results that print themselves, in the user's units."""
