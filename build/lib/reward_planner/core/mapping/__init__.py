"""Local maps from voxels, the global map, and poses for sensor frames."""
