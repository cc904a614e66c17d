"""Cameras: settings, calibration, images of topics and of files."""
