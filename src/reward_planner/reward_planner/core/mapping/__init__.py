"""Voxels projected to the floor, and what they leave in the map of the whole area."""
