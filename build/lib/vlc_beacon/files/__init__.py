"""Files of the package: beacons, key, counters, blooming, poses."""
