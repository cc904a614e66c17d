"""Taught places, calibrations and results as files."""
