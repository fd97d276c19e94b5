"""Check before physics: mistakes in how a measurement set is stated, such as a wrong unit."""
