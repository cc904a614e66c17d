"""Protocol, kinematics, limits and odometry: no ROS, no files, no serial line."""
