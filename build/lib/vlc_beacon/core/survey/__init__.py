"""Survey of beacon positions from a drive with known poses."""
