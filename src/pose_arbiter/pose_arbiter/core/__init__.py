"""The method: numbers only, no ROS, no files, no clock."""
