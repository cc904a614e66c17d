"""Files of taught places, calibrations and results."""
