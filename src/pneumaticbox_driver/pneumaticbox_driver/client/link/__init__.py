"""What the client stands on: its own ROS context, its waiting and its calls."""
