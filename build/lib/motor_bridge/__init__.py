"""Drives a differential drive robot over a serial motor controller and publishes wheel odometry."""
