"""Where a model fails: its residual as a function of every axis of a set."""
