"""Bags (rosbag2 folders, MCAP): written, repaired when truncated, and read as arrays."""
