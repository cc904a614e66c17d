"""Calibration boards and the calibration of lenses and stereo pairs, without ROS and files."""
