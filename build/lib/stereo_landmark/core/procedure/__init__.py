"""Detects taught targets from primitives in stereo images: procedure tree, pose hypotheses and their acceptance."""
