"""The node's ROS interface: sensor subscriptions, map topics and services, action server and diagnostics."""
