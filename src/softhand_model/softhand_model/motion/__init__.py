"""A hand in time without contact: pressures and a wrist that move it."""
