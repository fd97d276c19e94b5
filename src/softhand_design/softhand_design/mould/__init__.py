"""Two-part casting moulds of actuators: their surfaces, and checks that measure them."""
