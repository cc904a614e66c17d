"""Calibrate the mount of the belly camera from an image of a known mat."""
