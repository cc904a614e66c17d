"""Files of the package: the key and the counters."""
