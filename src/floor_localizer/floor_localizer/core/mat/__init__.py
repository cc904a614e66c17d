"""Mats with random dots to print."""
