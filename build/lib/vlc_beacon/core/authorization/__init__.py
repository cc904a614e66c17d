"""Authorization of commands: authentic, new, sent by the right lamp at the right location, and plausible."""
