"""Grids: where their cells lie, and which of them the robot may enter."""
