"""Rendered worlds with known truth: random-dot floors, a belly camera and a robot's drive."""

from shirube_core.read_only import ensure_numba_cache

ensure_numba_cache(__file__)
