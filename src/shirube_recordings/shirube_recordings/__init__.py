"""Reads images with calibration, odometry and tilt from a bag, in message order."""
