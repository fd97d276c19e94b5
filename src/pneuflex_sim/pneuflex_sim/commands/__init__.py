"""The commands of the package, one file each."""
