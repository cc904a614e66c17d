"""Localization and visible light communication (VLC) with ceiling LED beacons."""

from shirube_core.read_only import ensure_numba_cache

ensure_numba_cache(__file__)
