"""Files that are read and written: YAML within limits, results that overwrite nothing, quoting."""
