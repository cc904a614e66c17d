"""ROS glue of the nodes: parameters, images, poses, QoS, diagnostics, a safe main."""
