"""The thesis's experiments made again, outside the installed packages."""
