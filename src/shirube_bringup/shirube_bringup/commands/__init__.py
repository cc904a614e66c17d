"""Executables of shirube_bringup."""
