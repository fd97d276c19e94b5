"""Nodes of the recorder, of the demo and of sessions at the bench: all here that imports ROS."""
