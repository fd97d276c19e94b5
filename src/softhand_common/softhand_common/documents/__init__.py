"""Reading and writing of files: YAML within limits, results without overwriting, quoting."""
