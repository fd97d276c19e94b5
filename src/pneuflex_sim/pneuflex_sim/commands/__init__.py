"""The commands of the package, one file for each."""
