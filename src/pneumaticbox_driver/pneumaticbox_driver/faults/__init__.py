"""Faults of valves, tubes and sensors, detected from the effects of pulses."""
