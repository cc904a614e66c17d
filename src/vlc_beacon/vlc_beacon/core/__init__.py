"""The method without ROS and without files: brightness of lamps in, packets and verdicts out."""
