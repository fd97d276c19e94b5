"""What a program needs to play something on the simulated bench: a ROS side, and patience."""
