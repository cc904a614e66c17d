"""Transmitter: frames for the lamp firmware, computed on the host."""
