"""Surroundings of the hand: scenes, objects, their meshes, friction and contacts."""
