"""Pose of a robot from the random dots of the floor under it."""

from shirube_core.read_only import ensure_numba_cache

ensure_numba_cache(__file__)
