"""One module per experiment: what a model predicts for its runs, for many trial values at once."""
