"""Which commands are obeyed: keys, counters, lockout and plausibility."""
