"""The node `monitor`: all of this package that imports ROS."""
