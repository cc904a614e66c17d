"""The method without ROS and without files: a pair of images in, the displacement from the taught pose out."""
