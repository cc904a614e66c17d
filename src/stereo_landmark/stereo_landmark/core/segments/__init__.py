"""Edges to segments: line following, polylines, chain codes, neighbours (paper 3.4)."""
