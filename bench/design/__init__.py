"""From materials to an actuator that does what was wanted: tables, sizes, simulation, moulds."""
