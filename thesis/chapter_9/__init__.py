"""Chapter 9: success of grasps that use an edge or a wall."""
