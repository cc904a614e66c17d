"""Pose of a robot from the random dots of the floor under it."""
