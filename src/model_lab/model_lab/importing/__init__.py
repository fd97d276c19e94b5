"""Import of measurement files: what their columns mean, and the measurement set made of them."""
