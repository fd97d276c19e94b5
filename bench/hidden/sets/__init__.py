"""Measurement sets with hidden laws, by kind of experiment, written as folders."""
