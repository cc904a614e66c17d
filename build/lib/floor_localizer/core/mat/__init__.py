"""Printable random-dot mats, and calibration of the belly camera over one."""
