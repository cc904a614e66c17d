"""Shortest routes on a grid, anew and after changes."""
