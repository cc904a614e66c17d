"""True projections of lamps into a frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.camera_motion import CameraMotion, CameraPose
from scene_simulator.ceiling_lamp import CeilingLamp
from scene_simulator.shutter import Shutter
from shirube_core.geometry import PinholeCamera


@dataclass(frozen=True)
class LampProjection:
    """True projection of a lamp in a frame, without its glow.

    All of it holds for ``time``, when the row that the lamp's middle falls on is in the middle of its exposure.

    Attributes:
        lamp: its index in the room.
        time: middle of that exposure [s].
        centre: pixel u, v of the middle of the lamp's face [px].
        centroid: pixel u, v of the middle of its outline's area [px]; perspective and distortion part it from
            the centre when the camera tilts.
        radius: radius of the disc of the outline's area [px].
        rows: first row and the row after the last whose middle is between the outline's ends, both clipped
            to the image.
    """

    lamp: int
    time: float
    centre: tuple[float, float]
    centroid: tuple[float, float]
    radius: float
    rows: tuple[int, int]


def project_lamp(
    index: int,
    lamp: CeilingLamp,
    camera: PinholeCamera,
    shutter: Shutter,
    stamp: float,
    motion: CameraMotion,
) -> LampProjection | None:
    """Return the projection of a lamp, also outside the image; None outside the view cone.

    Args:
        index: the lamp's index in the room.
        lamp: the lamp.
        camera: the camera's intrinsics.
        shutter: its timing.
        stamp: stamp of the frame [s].
        motion: camera trajectory during the frame.
    """
    time = shutter.frame_middle(stamp, camera.height)
    # The row on which the middle falls gives the time, and the time the row: they settle at once.
    for _ in range(3 if shutter.row_time > 0.0 else 1):
        points = motion.pose(time).camera_points(
            lamp.map_points(np.vstack([np.zeros(2), lamp.shape.outline()]))
        )
        if not is_in_view(points, camera).all():
            return None
        pixels = camera.pixels_from_points(points)
        row = min(max(float(pixels[0, 1]), 0.0), camera.height - 1.0)
        time = shutter.row_middle(stamp, row)
    area, centroid = _area_and_centroid(pixels[1:])
    lowest, highest = np.clip(
        [np.ceil(pixels[1:, 1].min()), np.floor(pixels[1:, 1].max()) + 1], 0, camera.height
    )
    return LampProjection(
        index,
        time,
        (float(pixels[0, 0]), float(pixels[0, 1])),
        (float(centroid[0]), float(centroid[1])),
        float(np.sqrt(area / np.pi)),
        (int(lowest), int(max(highest, lowest))),
    )


def is_in_view(points_camera: NDArray[np.float64], camera: PinholeCamera) -> NDArray[np.bool_]:
    """Return which points, shape (n, 3), are in the view cone where the distortion model is valid.

    It reaches a third beyond the corners of the image: farther out ``plumb_bob`` may fold back into it.
    """
    corners = [(u, v) for u in (0.0, camera.width - 1.0) for v in (0.0, camera.height - 1.0)]
    widest = np.hypot(*camera.rays_from_pixels(corners)[:, :2].T).max()
    across = np.hypot(points_camera[:, 0], points_camera[:, 1])
    return np.asarray(across < 4.0 / 3.0 * widest * points_camera[:, 2])


def image_motion(
    point: NDArray[np.float64], camera: PinholeCamera, before: CameraPose, after: CameraPose
) -> float:
    """Return how far a point of the map frame, shape (3,), moves in the image between two poses [px]."""
    pixels = [camera.pixels_from_points(pose.camera_points(point[None, :]))[0] for pose in (before, after)]
    return float(np.hypot(*(pixels[1] - pixels[0])))


def _area_and_centroid(polygon: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
    """Return area [px^2] and centroid [px] of a polygon, shape (n, 2)."""
    origin = polygon.mean(axis=0)
    corners = polygon - origin
    next_corners = np.roll(corners, -1, axis=0)
    cross = corners[:, 0] * next_corners[:, 1] - corners[:, 1] * next_corners[:, 0]
    centroid = ((corners + next_corners) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum())
    return abs(float(cross.sum())) / 2.0, origin + centroid
