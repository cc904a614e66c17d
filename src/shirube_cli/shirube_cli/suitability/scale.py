"""Scale of a photograph of a floor, from a bank card or a coin on it."""

import math
from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_cli.project import CommandError
from shirube_cli.suitability.pictures import Image

_CARD = (85.60, 53.98)  # sides of a bank card, ISO/IEC 7810 ID-1 [mm]
_ASPECT_TOLERANCE, _SIDE_TOLERANCE = 0.06, 0.04
_AREA_MIN, _AREA_MAX = 0.002, 0.5  # of the photograph
_FILL_MIN = 0.9  # a card has round corners
_ROUNDNESS_MIN = 0.85
_BLUR = 7  # before edges are searched [px]


def find_card(image: Image) -> tuple[float, NDArray[np.int32]]:
    """Return the scale [mm/px] by a bank card on a photograph, and the card's outline; raises `CommandError`."""
    best: tuple[float, NDArray[np.int32]] | None = None
    error = _ASPECT_TOLERANCE
    for outline in _outlines(image):
        corners = cv2.boxPoints(cv2.minAreaRect(outline))
        sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
        long, short = float(max(sides[:2])), max(float(min(sides[:2])), 1.0)
        aspect = abs(long / short * _CARD[1] / _CARD[0] - 1.0)
        quadrilateral = cv2.approxPolyDP(outline, 0.03 * cv2.arcLength(outline, True), True)
        if aspect >= error or len(quadrilateral) != 4 or cv2.contourArea(outline) < _FILL_MIN * long * short:
            continue
        lengths = np.linalg.norm(np.roll(quadrilateral, -1, axis=0) - quadrilateral, axis=2).ravel()
        if np.abs(lengths[:2] / lengths[2:] - 1.0).max() < _SIDE_TOLERANCE:
            error, best = aspect, (0.5 * (_CARD[0] / long + _CARD[1] / short), outline)
    if best is not None:
        return best
    raise CommandError(
        'no bank card is found; lay it flat, photograph from straight above, or give --coin or --mm-per-pixel'
    )


def find_coin(image: Image, diameter: float) -> tuple[float, NDArray[np.int32]]:
    """Return the scale [mm/px] by the largest disc, a coin of this diameter [mm], and its outline.

    Raises:
        CommandError: no coin is found.
    """
    for outline in _outlines(image):
        _, radius = cv2.minEnclosingCircle(outline)
        if cv2.contourArea(outline) > _ROUNDNESS_MIN * math.pi * radius**2:
            return diameter / (2.0 * math.sqrt(cv2.contourArea(outline) / math.pi)), outline
    raise CommandError('no coin is found; lay it on a part of the floor that differs, or give --mm-per-pixel')


def _outlines(image: Image) -> Iterator[NDArray[np.int32]]:
    """Yield convex outlines of large areas that differ from the floor, the largest first."""
    smooth, masks = cv2.GaussianBlur(image, (_BLUR, _BLUR), 0), []
    for plane in cv2.split(cv2.cvtColor(smooth, cv2.COLOR_BGR2LAB)):
        _, bright = cv2.threshold(plane, 0, 255, cv2.THRESH_OTSU)
        edges = cv2.dilate(cv2.Canny(plane, 30, 90), np.ones((3, 3), np.uint8))
        masks += [bright, cv2.bitwise_not(bright), edges]
    found = [each for mask in masks for each in cv2.findContours(mask, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)[0]]
    low, high = _AREA_MIN * plane.size, _AREA_MAX * plane.size
    hulls = [cv2.convexHull(each) for each in found if low < cv2.contourArea(each) < high]
    for hull in sorted(hulls, key=cv2.contourArea, reverse=True):
        yield np.asarray(hull, np.int32)
