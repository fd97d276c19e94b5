"""The services of the box."""
