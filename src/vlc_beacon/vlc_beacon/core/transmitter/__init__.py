"""Frames of the lamp firmware: what the host computes and the lamp replays."""
