"""Where the belly camera sits, from an image of a known mat."""
