"""Fits of a model to a set, evaluated on held-out data, and the noise floor."""
