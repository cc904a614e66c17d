"""Executables of shirube_bags."""
