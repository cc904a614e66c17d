"""What finds lamps, and markers in their places, in rendered images, and the position that follows from it."""

from typing import NamedTuple, Protocol

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
_LOCATOR = BeaconLocator(BEACONS, MOUNT, None, EXACT)


class Found(NamedTuple):
    """What was found in an image: ids (n,), centres (n, 2), sigmas (n,) [px]; how many false ones."""

    ids: NDArray[np.int64]
    centres: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    false: int


class Finder(Protocol):
    """Finds lamps or what hangs in their places."""

    def find(self, view: View, light: Light, rng: np.random.Generator) -> Found:
        """Return what is found."""


class LampFinder:
    """Finds lamps in an image of a view; which is which is taken from the truth, since nothing is played here."""

    def __init__(self) -> None:
        self._detector = LampDetector()

    def find(self, view: View, light: Light, rng: np.random.Generator) -> Found:
        """Return what is found."""
        blobs = self._detector.detect(picture_of(view.pixels[view.visible], light, rng))
        distances = np.hypot(*(blobs.centroids[:, None] - view.pixels[None]).transpose(2, 0, 1))
        near = distances.min(axis=1) < NEAR
        ids = IDS[distances.argmin(axis=1)][near]
        return Found(ids, blobs.centroids[near], blobs.sigmas[near].max(axis=1), int((~near).sum()))


class MarkerFinder:
    """Finds printed markers of a family in the lamps' places."""

    def __init__(self, family: str) -> None:
        self._markers = Markers(family, sensitive=True)

    def find(self, view: View, light: Light, rng: np.random.Generator) -> Found:
        """Return what is found."""
        found = self._markers.find(self._markers.picture(view, light, rng))
        offsets = found.centres - view.pixels[found.ids - 1]
        near = np.hypot(offsets[:, 0], offsets[:, 1]) < NEAR
        sigmas, false = np.full(int(near.sum()), MARKER_SIGMA), found.others + int((~near).sum())
        return Found(found.ids[near], found.centres[near], sigmas, false)


def finders(run: Run) -> dict[str, Finder]:
    """Return all that this OpenCV allows."""
    if not is_available():
        run.note('OpenCV 4.7 or later is needed to compare with markers.')
        return {LAMPS: LampFinder()}
    return {LAMPS: LampFinder(), **{family: MarkerFinder(family) for family in FAMILIES}}


def locate_by_centres(found: Found) -> NDArray[np.float64] | None:
    """Return x and y [m] by least squares of the centres (``centroid``)."""
    fix = _LOCATOR.locate(_LOCATOR.rays(CAMERA, found.ids, found.centres, found.sigmas))
    return np.array([fix.T_map_base.x, fix.T_map_base.y]) if isinstance(fix, BeaconFix) else None
