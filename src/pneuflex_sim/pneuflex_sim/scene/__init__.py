"""What surrounds the hand: scenes, objects, their meshes, friction and contacts."""
