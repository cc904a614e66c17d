"""Shortest routes on a grid: A* over jump points, and incremental replanning with D* Lite."""
