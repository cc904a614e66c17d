"""Voxel map: points counted into voxels, ray traversal, and the values of voxels over time."""
