"""The whole suite drives a simulated robot through a room of unknown obstacles."""

from shirube_core.read_only import ensure_numba_cache

ensure_numba_cache(__file__)
