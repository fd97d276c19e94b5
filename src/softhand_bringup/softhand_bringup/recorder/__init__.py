"""The recorder: a process of its own that writes all topics of a domain to a bag."""
