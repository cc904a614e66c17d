"""Obstacle mapping, path planning and path following from depth cameras and point clouds."""
