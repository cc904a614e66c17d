"""Printable random-dot mats (calibration targets and small maps)."""
