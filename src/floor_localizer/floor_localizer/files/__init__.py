"""Files in and out: dot maps, calibrations, images, poses."""
