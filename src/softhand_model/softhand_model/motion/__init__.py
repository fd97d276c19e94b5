"""Motion of a hand without contact, driven by pressures and the wrist."""
