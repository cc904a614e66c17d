"""What a recorded drive shows to a method: images with calibration, odometry and tilt, in their order."""
