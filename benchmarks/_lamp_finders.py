"""What finds lamps, and markers in their places, in rendered images, and the methods that make a position of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, Protocol

import cv2
import numpy as np
from _lamp_markers import FAMILIES, Markers, is_available
from _lamp_methods import EXACT
from _lamp_pictures import Light, picture_of
from _lamp_room import BEACONS, CAMERA, IDS, LEVEL, MOUNT, PLACES, View
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.pose.radius_interval import LampDiscs, radius_interval, radius_interval_printed

NEAR = 5.0
"""What is found nearer to a lamp is that lamp [px]."""
MARKER_SIGMA = 0.2
"""Of a marker's centre [px]."""
LAMPS = 'lamps'
_LOCATOR = BeaconLocator(BEACONS, MOUNT, None, EXACT)

Place = NDArray[np.float64]
"""x and y [m]."""


class Found(NamedTuple):
    """What was found in an image: ids (n,), centres (n, 2), sigmas (n,) and radii (n,) [px]; how many false ones."""

    ids: NDArray[np.int64]
    centres: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    radii: NDArray[np.float64]
    false: int


class Finder(Protocol):
    """Finds lamps or what hangs in their places."""

    def find(self, view: View, light: Light, rng: np.random.Generator) -> Found:
        """Return what is found."""


class LampFinder:
    """Finds lamps in an image of a view; which is which is taken from the truth, since nothing is played here."""

    def __init__(self) -> None:
        """Make a detector."""
        self._detector = LampDetector()

    def find(self, view: View, light: Light, rng: np.random.Generator) -> Found:
        """Return what is found."""
        blobs = self._detector.detect(picture_of(view.pixels[view.visible], light, rng))
        distances = np.hypot(*(blobs.centroids[:, None] - view.pixels[None]).transpose(2, 0, 1))
        near = distances.min(axis=1) < NEAR
        ids = IDS[distances.argmin(axis=1)][near]
        sigmas = blobs.sigmas[near].max(axis=1)
        return Found(ids, blobs.centroids[near], sigmas, blobs.radii[near], int((~near).sum()))


class MarkerFinder:
    """Finds printed markers in the lamps' places."""

    def __init__(self, family: str) -> None:
        """Take the family's name."""
        self._markers = Markers(family, sensitive=True)

    def find(self, view: View, light: Light, rng: np.random.Generator) -> Found:
        """Return what is found."""
        found = self._markers.find(self._markers.picture(view, light, rng))
        offsets = found.centres - view.pixels[found.ids - 1]
        near = np.hypot(offsets[:, 0], offsets[:, 1]) < NEAR
        unknown = np.full(int(near.sum()), np.nan)
        false = found.others + int((~near).sum())
        return Found(
            found.ids[near], found.centres[near], np.full_like(unknown, MARKER_SIGMA), unknown, false
        )


def finders() -> dict[str, Finder]:
    """Return all that this OpenCV allows."""
    families = FAMILIES if is_available() else ()
    return {LAMPS: LampFinder(), **{family: MarkerFinder(family) for family in families}}


def rays_to_found(view: View, found: Found) -> View:
    """Return a view of which only what was found is visible."""
    return replace(view, visible=np.isin(IDS, found.ids))


def locate_by_centres(_view: View, found: Found) -> Place | None:
    """Locate by ``centroid``."""
    fix = _LOCATOR.locate(_LOCATOR.rays(CAMERA, found.ids, found.centres, found.sigmas))
    return np.array([fix.T_map_base.x, fix.T_map_base.y]) if isinstance(fix, BeaconFix) else None


def locate_by_radii(view: View, found: Found) -> Place | None:
    """Locate by ``radius_interval``, the yaw given."""
    return _locate_by_discs(view, found, is_printed=False)


def locate_by_printed_equations(view: View, found: Found) -> Place | None:
    """Locate by ``radius_interval_printed``, the yaw given."""
    return _locate_by_discs(view, found, is_printed=True)


def _locate_by_discs(view: View, found: Found, *, is_printed: bool) -> Place | None:
    discs = LampDiscs(
        [BEACONS[id_ - 1] for id_ in found.ids],
        found.centres,
        found.radii,
        float(found.sigmas.max(initial=0.0)),
    )
    method = radius_interval_printed if is_printed else radius_interval
    fix = method(discs, CAMERA, LEVEL, view.pose.yaw)
    return np.array([fix.T_map_base.x, fix.T_map_base.y]) if isinstance(fix, BeaconFix) else None


def locate_by_sqpnp(_view: View, found: Found) -> Place | None:
    """Locate by six degrees of freedom."""
    if len(found.ids) < len(IDS):
        return None
    solved, rotation, translation = cv2.solvePnP(
        PLACES[found.ids - 1], found.centres, CAMERA.matrix, None, flags=cv2.SOLVEPNP_SQPNP
    )
    return np.asarray((-cv2.Rodrigues(rotation)[0].T @ translation)[:2, 0]) if solved else None


METHODS: tuple[tuple[str, str, Callable[[View, Found], Place | None]], ...] = (
    ('`centroid`', LAMPS, locate_by_centres),
    ('`radius_interval`, yaw given', LAMPS, locate_by_radii),
    ('`radius_interval_printed`, yaw given', LAMPS, locate_by_printed_equations),
    ('SQPNP on the lamps', LAMPS, locate_by_sqpnp),
    *((f'{family}, by its centres', family, locate_by_centres) for family in FAMILIES),
)
"""Name, finder and method."""
