"""Localization without ROS running: recorded messages, and the command ``locate``."""
