"""Bags (rosbag2 folders, MCAP): write them, mend them when cut off, and read them as arrays."""
