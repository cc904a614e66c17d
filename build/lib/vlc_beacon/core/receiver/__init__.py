"""Receiver: images to lamp IDs, robot pose and commands."""
