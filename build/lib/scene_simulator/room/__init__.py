"""Rooms of boxes, and grid worlds."""
