"""The filter: no ROS, no files, no clock."""
