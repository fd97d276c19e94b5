"""The scene beyond ROS topics: simulator or bench and Pneumaticbox in other processes."""
