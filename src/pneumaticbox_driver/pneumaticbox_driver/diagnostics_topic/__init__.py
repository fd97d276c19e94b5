"""Publishes the reports of the box."""
