"""Which effects are missing: candidates, search, selection, verdict, and the next experiment."""
