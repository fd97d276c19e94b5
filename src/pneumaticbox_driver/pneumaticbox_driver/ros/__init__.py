"""The node `pneumaticbox` and its client: the only part of this package that imports ROS."""
