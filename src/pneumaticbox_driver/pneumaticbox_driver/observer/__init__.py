"""Observer of the air mass: pulses of equation 4.1 summed up, its drift, its zeroing."""
