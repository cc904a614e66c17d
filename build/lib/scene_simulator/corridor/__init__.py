"""Corridors with landmarks and the stereo camera in them."""
