"""What the box is connected to, beside the topics: the embedded bench."""
