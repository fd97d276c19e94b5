"""The observer of air mass: pulses of equation 4.1 summed up, its drift, and where masses are
known.
"""
