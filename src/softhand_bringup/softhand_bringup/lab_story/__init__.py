"""A finger whose simulator hides an effect: measured over ROS, diagnosed, mended, watched live."""
