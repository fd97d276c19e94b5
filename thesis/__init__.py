"""The thesis's experiments, made again on one frame: `python -m thesis list`."""
