"""From commands and poses to velocities."""
