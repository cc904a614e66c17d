"""Poses from lamps: where the robot is when it sees these lamps there."""
