"""The box without ROS: sensor samples and commands in, valves and diagnostics out."""
