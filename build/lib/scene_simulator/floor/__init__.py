"""Random-dot floors and the camera above them."""
