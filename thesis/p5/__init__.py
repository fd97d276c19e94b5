"""What a P5, the actuator of RBO Hand 1, lacks in the model (sections 7.2 and 8.1.2)."""
