"""How a robot moves, and what it measures of that."""
