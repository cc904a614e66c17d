"""The command ``shirube``: the one door to the suite for people who have no ROS installation."""
