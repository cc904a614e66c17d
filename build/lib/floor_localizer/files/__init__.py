"""Reading and writing of files: dot maps, calibrations, images, poses."""
