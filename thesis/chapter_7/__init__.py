"""Chapter 7: what the thesis says of RBO Hand 2, as measurements of the real hand."""
