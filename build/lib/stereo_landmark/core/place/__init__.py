"""Computes the robot's displacement from the taught pose from stereo point correspondences."""
