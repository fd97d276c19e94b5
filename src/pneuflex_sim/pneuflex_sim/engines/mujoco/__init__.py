"""MuJoCo: the world as an MJCF document, the springs of the hand, and the engine."""
