"""Robot poses from lamp observations."""
