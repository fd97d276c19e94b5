"""What the suite's nodes share; it knows rclpy and messages, and none of the other packages."""
