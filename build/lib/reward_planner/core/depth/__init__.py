"""Stereo depth from two or three rectified cameras, and points from depth images."""
