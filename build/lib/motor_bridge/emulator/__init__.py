"""Emulated motor controller and robot."""
