"""The demonstration: three nodes grasp and lift an object, a fourth process records them."""
