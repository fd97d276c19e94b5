"""Effects of the user's own: loaded from a file, rehearsed in another process, and guarded."""
