"""Out-of-core build of the binary form of large maps: in parts, in parallel, and resumable."""
