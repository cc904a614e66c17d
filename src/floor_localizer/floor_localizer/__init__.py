"""Where a robot is, told from the random dots of the floor under it."""
