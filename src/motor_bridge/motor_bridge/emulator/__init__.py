"""A motor controller and the robot around it, as software."""
