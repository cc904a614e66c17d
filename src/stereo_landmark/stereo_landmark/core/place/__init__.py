"""From points in two images to the robot's displacement from the taught pose."""
