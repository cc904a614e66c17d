"""Stereo localization relative to taught places by natural landmarks, without markers."""

from shirube_core.read_only import ensure_numba_cache

ensure_numba_cache(__file__)
