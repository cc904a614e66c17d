"""The paper's room: four lamps under the ceiling of 7 x 6 m, its camera, and the Cramér-Rao bound of its poses."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shirube_core.geometry import SE2, CameraMount, PinholeCamera, gravity_aligned_camera
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_least_squares import camera_points

CAMERA = PinholeCamera(1280, 1024, 636.4, 636.4, 639.5, 511.5)
WIDE = PinholeCamera(
    1280, 1024, 640.0 / math.tan(math.radians(52.95)), 512.0 / math.tan(math.radians(38.9)), 639.5, 511.5
)
"""The paper's 77.8 x 105.9 degrees as angles of the image's sides; its pitch and focal length give `CAMERA`."""
MOUNT = CameraMount((0.0, 0.0, 0.0), (0.0, 0.0, -math.pi / 2.0))
LEVEL = gravity_aligned_camera(MOUNT)
RADIUS = 0.0325
BEACONS = tuple(Beacon(k + 1, (x, y, 2.5), RADIUS) for k, (x, y) in enumerate(((0, 0), (0, 1.8), (1.8, 0), (1.8, 1.8))))
PLACES = np.array([beacon.xyz for beacon in BEACONS])
IDS = np.array([beacon.id for beacon in BEACONS])
ROOM = (7.0, 6.0)  # [m]; the lamps' square hangs in its middle
LAMP_RADIUS = RADIUS * CAMERA.fx / 2.5  # of each lamp in the image of a level camera [px]


@dataclass(frozen=True)
class View:
    """What the camera sees from a place.

    Attributes:
        pose: ``T_map_base``.
        pixels: shape (4, 2), true centres of all lamps [px].
        visible: shape (4,), lamps that are wholly in the image.
    """

    pose: SE2
    pixels: NDArray[np.float64]
    visible: NDArray[np.bool_]


def view_from(pose: SE2, roll: float = 0.0, pitch: float = 0.0, camera: PinholeCamera = CAMERA) -> View:
    """Return the view of a robot on the floor that leans by roll and pitch [rad]."""
    pixels = camera.pixels_from_points(
        camera_points(state_of(pose), PLACES, np.zeros((4, 3)), gravity_aligned_camera(MOUNT, roll, pitch))
    )
    size = np.array([camera.width, camera.height])
    margin = LAMP_RADIUS + 1.0
    inside = (pixels >= margin) & (pixels <= size - 1 - margin)
    return View(pose, pixels, np.asarray(inside.all(axis=1)))


def random_views(count: int, rng: np.random.Generator, camera: PinholeCamera = CAMERA) -> Iterator[View]:
    """Yield views from anywhere in the room in any heading."""
    for _ in range(count):
        x, y = (0.9 + rng.uniform(-0.5 * side, 0.5 * side) for side in ROOM)
        yield view_from(SE2(x, y, rng.uniform(-math.pi, math.pi)), camera=camera)


def state_of(pose: SE2) -> NDArray[np.float64]:
    """Return the state of a pose on the floor, see `bearing_model`."""
    return np.array([pose.x, pose.y, 0.0, pose.yaw, 0.0, 0.0])


def cramer_rao_bound(view: View, noise: ArrayLike, *, height_known: bool) -> float:
    """Return the least mean square error of the position in the plane [m^2], by differences of the projection.

    Args:
        view: whose visible lamps count.
        noise: array-like, broadcast to shape (4, 2), standard deviation of each coordinate of each lamp [px].
        height_known: whether z is given.
    """
    sigmas = np.broadcast_to(np.asarray(noise, dtype=np.float64), (4, 2))[view.visible]
    columns = []
    for k in (0, 1, 3) if height_known else (0, 1, 3, 2):
        step = np.eye(6)[k] * 1e-6
        above, below = (
            CAMERA.pixels_from_points(
                camera_points(state_of(view.pose) + sign * step, PLACES, np.zeros((4, 3)), LEVEL)
            )[view.visible]
            for sign in (1.0, -1.0)
        )
        columns.append(((above - below) / 2e-6 / sigmas).ravel())
    J = np.column_stack(columns)
    return float(np.trace(np.linalg.inv(J.T @ J)[:2, :2]))
