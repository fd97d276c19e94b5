"""The node `hand_sim`: all of this package that imports ROS."""
