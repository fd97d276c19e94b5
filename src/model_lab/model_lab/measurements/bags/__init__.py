"""Rosbag2 folders and ROS 1 bags, read without ROS."""
