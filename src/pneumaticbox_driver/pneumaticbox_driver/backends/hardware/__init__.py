"""A real box: valves on GPIO lines and pressure sensors on analog inputs, or another board."""
