"""The model lab: compare the model with measurements, name what is missing, add it."""
