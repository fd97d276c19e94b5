"""Common parts of the suite's nodes; depends on rclpy and messages, on no other package."""
