"""Localization and visible light communication (VLC) with ceiling LED beacons."""
