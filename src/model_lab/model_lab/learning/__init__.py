"""What is missing where no known effect fits: a curve, where it acts and against what."""
