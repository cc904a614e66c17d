"""The method without ROS and without files: images and dots in, poses out."""
