"""What hostile messages, damaged files and ended processes do to the suite."""
