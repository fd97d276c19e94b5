"""Compiled dynamics of serial chains: spatial vectors, articulated bodies, implicit springs."""
