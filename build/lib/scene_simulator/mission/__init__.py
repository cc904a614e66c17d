"""The room of the mission and the sensors in it."""
