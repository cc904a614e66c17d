"""Lamps in grey images: where they are, how large, how bright, and which is which from image to image."""
