"""Executables of the mission."""
