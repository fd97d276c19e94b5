"""The model of a running hand: predictions and residuals, sample by sample."""
