"""Replanning, path following and velocity control on the global map."""
