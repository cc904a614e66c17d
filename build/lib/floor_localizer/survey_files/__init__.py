"""Files of a survey: its images with their odometry, checkpoints, report and pictures."""
