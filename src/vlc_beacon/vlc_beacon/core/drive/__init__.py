"""Velocity commands from lamp commands and poses."""
