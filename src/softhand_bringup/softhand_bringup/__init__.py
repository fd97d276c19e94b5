"""Starts, records and shows the suite: launcher, bag recorder, demo and figures."""
