"""Files of parameters."""
