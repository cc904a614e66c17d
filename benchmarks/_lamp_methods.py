"""Ways from the lamps of a view to a position, each with the same arguments."""

import math
from collections.abc import Callable
from functools import partial

import cv2
import numpy as np
from _lamp_room import BEACONS, CAMERA, IDS, LAMP_RADIUS, LEVEL, MOUNT, PLACES, View
from numpy.typing import NDArray

from shirube_core.geometry import SE3
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.pose.radius_interval import LampDiscs, radius_interval, radius_interval_printed
from vlc_beacon.core.settings import PoseSettings

EXACT = PoseSettings(pixel_sigma=0.0, beacon_sigma=0.0, tilt_sigma=0.0)  # lens, lamps and tilt are exact in these views

TURNED = SE3(np.diag([-1.0, -1.0, 1.0]) @ LEVEL.rotation, LEVEL.position)
"""The paper leaves the axes of its image open; turned by 180 degrees, the plus of eq. (5) is right in x and y."""

Locate = Callable[[View, NDArray[np.float64], float], NDArray[np.float64] | None]
"""From a view, its pixels with noise, shape (4, 2), and the noise [px] to x and y [m]."""


def locate_by_centres(
    view: View, pixels: NDArray[np.float64], noise: float, *, height: float | None = None
) -> NDArray[np.float64] | None:
    """Locate by the method ``centroid`` on the visible lamps; with the height of the base [m], if it is known."""
    seen, locator = view.visible, BeaconLocator(BEACONS, MOUNT, height, EXACT)
    fix = locator.locate(locator.rays(CAMERA, IDS[seen], pixels[seen], np.full(seen.sum(), noise)))
    return np.array([fix.T_map_base.x, fix.T_map_base.y]) if isinstance(fix, BeaconFix) else None


def pixel_count_radii(view: View) -> NDArray[np.float64]:
    """Return half the number of pixels that each lamp covers along its row, as the paper counts, shape (4,)."""
    u = view.pixels[:, 0]
    return np.asarray(0.5 * (np.floor(u + LAMP_RADIUS) - np.ceil(u - LAMP_RADIUS) + 1.0))


def locate_by_radius(
    view: View, pixels: NDArray[np.float64], noise: float, *, yaw_error: float = 0.0
) -> NDArray[np.float64] | None:
    """Locate by the paper's equations, corrected, with the yaw given, four lamps."""
    discs = LampDiscs(BEACONS, pixels, pixel_count_radii(view), noise)
    fix = radius_interval(discs, CAMERA, LEVEL, view.pose.yaw + yaw_error)
    return np.array([fix.T_map_base.x, fix.T_map_base.y]) if isinstance(fix, BeaconFix) else None


def locate_as_printed(
    view: View, pixels: NDArray[np.float64], noise: float, *, camera: SE3 = LEVEL, focal_scale: float = 2.0
) -> NDArray[np.float64] | None:
    """Locate by the equations as printed, with the yaw given; `TURNED` absorbs the sign of eq. (5)."""
    discs = LampDiscs(BEACONS, pixels, pixel_count_radii(view), noise)
    fix = radius_interval_printed(discs, CAMERA, camera, view.pose.yaw, focal_scale)
    return np.array([fix.T_map_base.x, fix.T_map_base.y]) if isinstance(fix, BeaconFix) else None


def locate_by_sqpnp(_view: View, pixels: NDArray[np.float64], _noise: float) -> NDArray[np.float64] | None:
    """Locate by six degrees of freedom, four lamps."""
    found, rotation, translation = cv2.solvePnP(PLACES, pixels, CAMERA.matrix, None, flags=cv2.SOLVEPNP_SQPNP)
    if not found:
        return None
    place = -cv2.Rodrigues(rotation)[0].T @ translation
    return np.asarray(place[:2, 0])


ALL, TWO = 4, 2
METHODS: tuple[tuple[str, int, Locate, bool | None], ...] = (
    ("the paper's eqs. as printed, yaw given", ALL, locate_as_printed, None),
    ('printed, image axes turned by 180°', ALL, partial(locate_as_printed, camera=TURNED), None),
    (
        'printed, turned, eq. (2) with its factor 1/2',
        ALL,
        partial(locate_as_printed, camera=TURNED, focal_scale=1.0),
        None,
    ),
    ('`radius_interval`, all corrections', ALL, locate_by_radius, None),
    ('the same, yaw off by 5°', ALL, partial(locate_by_radius, yaw_error=math.radians(5.0)), None),
    ('SQPNP, six degrees of freedom', ALL, locate_by_sqpnp, None),
    ('`centroid`', TWO, locate_by_centres, False),
    ('`centroid`, height known', TWO, partial(locate_by_centres, height=0.0), True),
    ('`centroid`, four lamps', ALL, locate_by_centres, False),
)
"""Name, least number of lamps, method, and whether the height is known, None where no bound is compared."""
