"""The localization method, without ROS and file access: stereo pair in, displacement from the taught pose out."""
