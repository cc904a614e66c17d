"""A dot map from images of the floor with rough odometry."""
