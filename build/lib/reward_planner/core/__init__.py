"""Mapping, planning and control without ROS and without files."""
