"""Measurement sets before anything is measured: one module for each kind of set, outputs zero.

Every set has two repeats of six protocols of 200 samples.
"""
