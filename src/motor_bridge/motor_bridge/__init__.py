"""Drives two wheels over a serial motor controller and tells how far they went."""
