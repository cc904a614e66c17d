"""Executables of the package."""
