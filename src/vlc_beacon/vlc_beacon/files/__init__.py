"""Files of the package: lamps, key, counters, blooming, poses."""
