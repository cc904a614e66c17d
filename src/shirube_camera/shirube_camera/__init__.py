"""Publishes images of USB cameras, videos and folders, and calibrates lenses and stereo pairs."""
