"""Commands that work without a running ROS."""
