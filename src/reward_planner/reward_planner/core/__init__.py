"""The method without ROS and without files: what was seen in, maps and routes out."""
