"""Ceiling LEDs tell a robot where it is and what to do."""
