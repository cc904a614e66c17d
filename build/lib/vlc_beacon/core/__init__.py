"""The method, without ROS and files: images in; poses, packets and authorized commands out."""
