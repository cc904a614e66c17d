"""Dot extraction (paper 3.1): detects the dots of an image."""
