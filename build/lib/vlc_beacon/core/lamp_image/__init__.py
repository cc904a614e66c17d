"""Lamp detection and tracking in grey images: position, size and brightness of each lamp."""
