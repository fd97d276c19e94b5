"""Common parts of all packages: documents, numerics, progress of long work, status reports."""
