"""Camera images to synchronized, rectified stereo pairs and their localization results."""
