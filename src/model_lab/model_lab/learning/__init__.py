"""Learning of a curve where no known effect explains the error: the stage in which it acts, and the
axis on which it depends."""
