"""Nodes of the recorder, the demo and the lab story: the only part that imports ROS."""
