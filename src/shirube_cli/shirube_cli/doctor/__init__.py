"""`shirube doctor`: what is wrong with a system, in plain words."""
