"""Fuses the poses of several localizers and wheel odometry into one pose."""
