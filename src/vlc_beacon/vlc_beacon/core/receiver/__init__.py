"""From images to what the robot gets from its lamps: names, pose, commands."""
