"""Grasps that use the environment: criteria of the maps, objects on the table, steps, rates."""
