"""Running nodes on the page."""
