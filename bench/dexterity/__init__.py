"""Benchmark of dexterity: what the fingers of RBO Hand 2 do with each other."""
