"""The ROS side of the pushes; the only place of the experiments that imports rclpy."""
