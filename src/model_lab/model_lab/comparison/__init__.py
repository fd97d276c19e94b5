"""A model compared with measurements, or several; and an effect added to it."""
