"""Executables of shirube_mission."""
