"""Where a model fails: its residual against every axis of a set."""
