"""Renders a textured plate through any homography: blobs of paint within a blurred outline."""

import numpy as np
from scipy.special import ndtr

SIZE = 120, 140
"""Height and width of a picture [px]."""
CORNERS = np.array([[40.0, 35.0], [100.0, 35.0], [100.0, 85.0], [40.0, 85.0]])
"""Corners of the plate in the first picture [px]."""
EDGE = 0.8
"""Blur of the outline [px]."""


def homography(scale=1.0, turn=0.0, shift=(0.0, 0.0), lean=0.0):
    """Return the homography from the first picture to another, about the plate's centre; lean is its perspective."""
    to_middle, back = np.eye(3), np.eye(3)
    to_middle[:2, 2], back[:2, 2] = -CORNERS.mean(axis=0), CORNERS.mean(axis=0) + shift
    cos, sin = scale * np.cos(turn), scale * np.sin(turn)
    return back @ np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [lean / 60.0, 0.0, 1.0]]) @ to_middle


def moved(points, H):
    """Return points mapped to another picture, shape (n, 2)."""
    projected = np.column_stack([points, np.ones(len(points))]) @ H.T
    return projected[:, :2] / projected[:, 2:]


def light(H=None, seed=1, blobs=40, fineness=(1.5, 3.0)):
    """Return a picture without noise, shape SIZE, with random blobs of paint."""
    rng = np.random.default_rng(seed)
    H = np.eye(3) if H is None else H
    rows, columns = np.indices(SIZE)
    x, y = moved(np.column_stack([columns.ravel(), rows.ravel()]), np.linalg.inv(H)).T
    low, high = CORNERS[0], CORNERS[2]
    inside = (ndtr((x - low[0]) / EDGE) - ndtr((x - high[0]) / EDGE)) * (
        ndtr((y - low[1]) / EDGE) - ndtr((y - high[1]) / EDGE)
    )
    level = np.full(len(x), 120.0)
    for _ in range(blobs):
        u, v = rng.uniform(low + 5.0, high - 5.0)
        sigma, depth = rng.uniform(*fineness), rng.uniform(-50, 50)
        level += depth * np.exp(-((x - u) ** 2 + (y - v) ** 2) / (2.0 * sigma**2))
    return (60.0 + inside * (level - 60.0)).reshape(SIZE)


def photograph(picture, noise=2.0, rng=None):
    """Return an 8 bit image with noise."""
    rng = rng or np.random.default_rng(0)
    noisy = picture + noise * rng.normal(size=picture.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
