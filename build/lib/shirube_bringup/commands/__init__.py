"""The executable of the mission."""
