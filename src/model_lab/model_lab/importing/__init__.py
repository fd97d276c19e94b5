"""Import of files as people have them: what their columns are, and the measurement set of them."""
