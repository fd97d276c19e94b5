"""The lab story: a hidden effect is measured over ROS, diagnosed, added to the model, monitored."""
