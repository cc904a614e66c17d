"""Executables: each a thin command around the simulator."""
