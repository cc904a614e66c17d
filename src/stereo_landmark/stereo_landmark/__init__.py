"""Stereo localization relative to taught places by natural landmarks, without markers."""
