"""Edge detection: grey image to thin edges with subpixel positions (paper 3.3b)."""
