"""One pose from all localizers and odometry."""
