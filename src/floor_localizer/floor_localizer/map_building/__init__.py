"""Builds the binary form of maps that do not fit into memory: in parts, in parallel, and restartable."""
