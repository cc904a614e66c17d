"""What all packages share, without ROS: poses, cameras, typed settings, files, lamp waveforms."""
