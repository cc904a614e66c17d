"""From what two cameras send to rectified pairs of images and what they tell."""
