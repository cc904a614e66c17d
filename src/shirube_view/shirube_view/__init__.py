"""Live page in the browser: what the robot sees, where it is, what it plans; goals, driving by hand, replay."""
