"""The suite's processes: their commands, their environment, start and end, waiting."""
