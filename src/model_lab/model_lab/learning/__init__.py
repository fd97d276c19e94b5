"""Learning of a curve where no known effect explains the error: where it acts, and against what."""
