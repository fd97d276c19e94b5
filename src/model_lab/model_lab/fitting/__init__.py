"""Fits of a model to a set, judged on held-out data, and the noise floor beside them."""
