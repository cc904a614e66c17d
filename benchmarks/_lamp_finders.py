"""What finds lamps, and markers in their places, in rendered images, and the position that follows from it."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from _harness import Run
from _lamp_markers import FAMILIES, Markers, is_available
from _lamp_methods import EXACT
from _lamp_pictures import Light, picture_of
from _lamp_room import BEACONS, CAMERA, IDS, MOUNT, View
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.pose_fix import BeaconFix

NEAR = 5.0  # what is found nearer to a lamp is that lamp [px]
MARKER_SIGMA = 0.2  # of a marker's centre [px]
LAMPS = 'lamps'
_DETECTOR, _LOCATOR = LampDetector(), BeaconLocator(BEACONS, MOUNT, None, EXACT)


class Found(NamedTuple):
    """What was found in an image: ids (n,), centres (n, 2), sigmas (n,) [px]; how many false ones."""

    ids: NDArray[np.int64]
    centres: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    false: int


Finder = Callable[[View, Light, np.random.Generator], Found]
"""Finds lamps or what hangs in their places."""


def find_lamps(view: View, light: Light, rng: np.random.Generator) -> Found:
    """Find lamps in an image of a view; which is which is taken from the truth, since nothing is played here."""
    blobs = _DETECTOR.detect(picture_of(view.pixels[view.visible], light, rng))
    distances = np.hypot(*(blobs.centroids[:, None] - view.pixels[None]).transpose(2, 0, 1))
    near = distances.min(axis=1) < NEAR
    ids = IDS[distances.argmin(axis=1)][near]
    return Found(ids, blobs.centroids[near], blobs.sigmas[near].max(axis=1), int((~near).sum()))


def marker_finder(family: str) -> Finder:
    """Return what finds printed markers of a family in the lamps' places."""
    markers = Markers(family, sensitive=True)

    def find(view: View, light: Light, rng: np.random.Generator) -> Found:
        ids, centres, others = markers.find(markers.picture(view, light, rng))
        near = np.hypot(*(centres - view.pixels[ids - 1]).T) < NEAR
        sigmas = np.full(int(near.sum()), MARKER_SIGMA)
        return Found(ids[near], centres[near], sigmas, others + int((~near).sum()))

    return find


def finders(run: Run) -> dict[str, Finder]:
    """Return all that this OpenCV allows."""
    if not is_available():
        run.note('OpenCV 4.7 or later is needed to compare with markers.')
        return {LAMPS: find_lamps}
    return {LAMPS: find_lamps, **{family: marker_finder(family) for family in FAMILIES}}


def position_error(view: View, found: Found) -> float:
    """Return the error of the pose by least squares of the centres (``centroid``) [m], NaN where there is none."""
    fix = _LOCATOR.locate(_LOCATOR.rays(CAMERA, found.ids, found.centres, found.sigmas))
    return fix.T_map_base.distance_to(view.pose) if isinstance(fix, BeaconFix) else math.nan
