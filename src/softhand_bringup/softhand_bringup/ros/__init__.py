"""The recorder and the ROS sides of demo and story: all of this package that imports ROS."""
