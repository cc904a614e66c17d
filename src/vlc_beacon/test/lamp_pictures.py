"""Supersampled images of lamps: discs, half discs, bands, blooming, noise."""

import math

import cv2
import numpy as np
from scipy.special import expit

FINE = 8


def draw_lamp(picture, centre, radius, level, *, halves=(1.0, 1.0), angle=0.0, blur=0.6, rows=None):
    """Add a disc to a picture, shape (h, w) of float.

    ``halves`` are the levels of its halves, the first one towards ``angle`` [rad]; ``rows`` is a function from rows to
    the share of the light that they show.
    """
    u, v = centre
    reach = radius + 6.0
    left, right = max(int(u - reach), 0), min(int(u + reach) + 2, picture.shape[1])
    top, bottom = max(int(v - reach), 0), min(int(v + reach) + 2, picture.shape[0])
    x = (np.arange((right - left) * FINE) + 0.5) / FINE - 0.5 + left - u
    y = (np.arange((bottom - top) * FINE) + 0.5)[:, None] / FINE - 0.5 + top - v
    along = x * math.cos(angle) + y * math.sin(angle)
    lamp = np.where(along > 0.0, *halves) * (x**2 + y**2 <= radius**2)
    lamp = cv2.GaussianBlur(lamp, (0, 0), blur * FINE)
    lamp = lamp.reshape(bottom - top, FINE, right - left, FINE).mean(axis=(1, 3))
    if rows is not None:
        lamp *= rows(np.arange(top, bottom))[:, None]
    picture[top:bottom, left:right] += level * lamp
    return picture


def blinking_rows(tone, row_time, exposure, phase=0.0):
    """Return the share of the light that rows show of a lamp that blinks evenly."""

    def share(rows):
        moments = rows[:, None] * row_time + np.linspace(0.0, exposure, 40) + phase
        return (moments * tone % 1.0 < 0.5).mean(axis=1)

    return share


def room(height=300, width=400, level=4.0, gradient=0.0):
    """Return an empty picture, brighter to the right by ``gradient`` over its width."""
    return np.full((height, width), level) + np.linspace(0.0, gradient, width)


def photograph(picture, noise=1.0, rng=None):
    """Return the image of a picture, of uint8."""
    if rng is not None:
        picture = picture + noise * rng.normal(size=picture.shape)
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


# What the notes of one real lamp say: [1/px], [px], [px], [m].
ALPHA, BETA, FOCAL, LAMP_RADIUS = 2.4, 2.5, 636.4, 0.0325


def blooming_image(shape, centre, depth, gamma, rng=None):
    """Return an image of eq. (4) corrected, written out here once more, and the lamp's radius in it."""
    p = LAMP_RADIUS * FOCAL / depth
    v, u = np.mgrid[: shape[0], : shape[1]]
    distance = np.hypot(u - centre[0], v - centre[1])
    outside = (220.0 - gamma) * (1.0 - expit(ALPHA * (distance - p - BETA))) + gamma
    return photograph(np.where(distance <= p, 220.0, outside), 1.5, rng), p
