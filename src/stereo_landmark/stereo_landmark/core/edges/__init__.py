"""Grey image to thin edges with sub-pixel positions (paper 3.3b)."""
