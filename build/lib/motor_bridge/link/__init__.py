"""The serial link to the motor controller."""
