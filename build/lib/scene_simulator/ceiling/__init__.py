"""Lamps on a ceiling and the camera below them."""
