"""Obstacle mapping, path planning and path following from depth cameras and point clouds."""

from shirube_core.read_only import ensure_numba_cache

ensure_numba_cache(__file__)
