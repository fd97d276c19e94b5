"""A page in the browser to see hands, to move them, and to view recordings."""
