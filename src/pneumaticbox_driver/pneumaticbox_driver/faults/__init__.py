"""Faults of valves, tubes and sensors, recognised from what pulses do."""
