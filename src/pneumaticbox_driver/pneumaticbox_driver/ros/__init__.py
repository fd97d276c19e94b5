"""The node `pneumaticbox` and its client: all of this package that imports ROS."""
