"""The model beside a running hand: predictions and residuals, sample by sample."""
