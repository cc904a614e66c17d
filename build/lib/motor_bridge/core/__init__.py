"""Protocol, kinematics, velocity limits and odometry, without ROS, files or the serial port."""
