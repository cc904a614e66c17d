"""Occupancy grids: geometry, cell values and obstacle inflation."""
