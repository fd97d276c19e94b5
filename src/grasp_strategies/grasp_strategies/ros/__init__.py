"""The node `grasp_sequencer`: all of this package that imports ROS."""
