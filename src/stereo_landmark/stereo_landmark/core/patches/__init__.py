"""Taught patches of a plane, found again in other images by their grey values."""
