"""Renders lamps into a frame; their true projections."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scene_simulator.ceiling.lamp import CeilingLamp
from scene_simulator.ceiling.lamp_profile import face_homographies, lamp_profiles
from scene_simulator.ceiling.lens import CeilingLens
from scene_simulator.imaging.exposure import CameraMotion, CameraPose, Shutter
from shirube_core.geometry import PinholeCamera

_MAX_LAMP_MOTION = 0.7  # smear of a lamp between two instants of an exposure [px]: its edges are softer
Window = tuple[slice, slice]


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
    """

    lamp: int
    time: float
    centre: tuple[float, float]
    centroid: tuple[float, float]
    radius: float


def project_lamp(
    index: int, lamp: CeilingLamp, camera: PinholeCamera, shutter: Shutter, stamp: float, motion: CameraMotion
) -> LampProjection | None:
    """Return the projection of the lamp of an index, also outside the image; None outside the view cone.

    The stamp is that of the frame [s], the motion is that of the camera during the frame.
    """
    time = shutter.frame_middle(stamp, camera.height)
    # The row on which the middle falls gives the time, and the time the row: they settle at once.
    for _ in range(3 if shutter.row_time > 0.0 else 1):
        points = motion.pose(time).camera_points(lamp.map_points(np.vstack([np.zeros(2), lamp.shape.outline()])))
        if not is_in_view(points, camera).all():
            return None
        pixels = camera.pixels_from_points(points)
        row = min(max(float(pixels[0, 1]), 0.0), camera.height - 1.0)
        time = shutter.row_middle(stamp, row)
    area, centroid = _area_and_centroid(pixels[1:])
    middle, centre = (float(pixels[0, 0]), float(pixels[0, 1])), (float(centroid[0]), float(centroid[1]))
    return LampProjection(index, time, middle, centre, float(np.sqrt(area / np.pi)))


def is_in_view(points_camera: NDArray[np.float64], camera: PinholeCamera) -> NDArray[np.bool_]:
    """Return which points, shape (n, 3), are in the view cone where the distortion model is valid.

    It reaches a third beyond the corners of the image.
    """
    corners = [(u, v) for u in (0.0, camera.width - 1.0) for v in (0.0, camera.height - 1.0)]
    widest = np.nanmax(np.hypot(*camera.rays_from_pixels(corners)[:, :2].T))
    across = np.hypot(points_camera[:, 0], points_camera[:, 1])
    is_valid = np.isfinite(camera.pixels_from_points(points_camera)[:, 0])
    return np.asarray(is_valid & (across < 4.0 / 3.0 * widest * points_camera[:, 2]))


def image_motion(point: NDArray[np.float64], camera: PinholeCamera, before: CameraPose, after: CameraPose) -> float:
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


@dataclass(frozen=True, eq=False)
class LampLight:
    """Lamps in one frame.

    Attributes:
        camera: the camera's intrinsics.
        shutter: its timing.
        lens: its lens.
        rays: shape (height + 2, width + 2, 2), rays of all pixels and of a border of one pixel, z = 1.
        motion: camera trajectory during the frame.
        stamp: stamp of the frame [s].
    """

    camera: PinholeCamera
    shutter: Shutter
    lens: CeilingLens
    rays: NDArray[np.float64]
    motion: CameraMotion
    stamp: float

    def add_lamp(self, light: NDArray[np.float32], index: int, lamp: CeilingLamp) -> LampProjection | None:
        """Add a lamp to a picture; return its true projection, None outside the view cone.

        Args:
            light: shape (height, width), in full wells, changed in place; the lens has not dimmed it yet.
            index: the lamp's index in the room.
            lamp: the lamp.
        """
        projection = project_lamp(index, lamp, self.camera, self.shutter, self.stamp, self.motion)
        time = projection.time if projection else self.shutter.frame_middle(self.stamp, self.camera.height)
        window = self._lamp_window(lamp)
        if window is not None:
            light[window] += self._render_lamp(lamp, window, self._count_instants(lamp, time))
        return projection

    def _render_lamp(self, lamp: CeilingLamp, window: Window, count: int) -> NDArray[np.float32]:
        """Return the light of a lamp in a window, whose exposure is cut into ``count`` equal parts."""
        rows, columns = window
        rays = self.rays[rows.start : rows.stop + 2, columns.start : columns.stop + 2]
        light = np.zeros((rows.stop - rows.start, columns.stop - columns.start), dtype=np.float32)
        times = self.shutter.exposure_boundaries(self.stamp, rows, count)
        for starts, stops in pairwise(times.T):
            poses = self.motion.poses(0.5 * (starts + stops))
            homographies = face_homographies(lamp.xyz, lamp.rotation, *poses)
            profiles = lamp_profiles(lamp, self.lens.blooming, rays, homographies)
            weights = lamp.brightness * self.shutter.exposure / count * lamp.mean_levels(starts, stops)
            light += np.einsum('ri,irc->rc', weights.astype(np.float32), profiles)
        return light

    def _count_instants(self, lamp: CeilingLamp, time: float) -> int:
        """Return into how many parts the exposure is cut, so that a lamp moves little within each."""
        points = lamp.map_points(lamp.shape.bounding_points())
        half = 0.5 * self.shutter.exposure
        before, after = (self.motion.pose(time + fraction).camera_points(points) for fraction in (-half, half))
        visible = is_in_view(before, self.camera) & is_in_view(after, self.camera)
        if not visible.any():
            return 1
        pixels_after, pixels_before = (self.camera.pixels_from_points(x[visible]) for x in (after, before))
        shift = pixels_after - pixels_before
        return max(1, math.ceil(float(np.hypot(*shift.T).max()) / _MAX_LAMP_MOTION))

    def _lamp_window(self, lamp: CeilingLamp) -> Window | None:
        """Return the part of the image that a lamp can reach in the frame, none when it reaches no pixel."""
        points = lamp.map_points(lamp.shape.bounding_points())
        end = self.shutter.frame_end(self.stamp, self.camera.height)
        times = np.linspace(self.stamp, end, 3).tolist()
        visible = [self.motion.pose(time).camera_points(points) for time in times]
        inside = np.vstack(visible)
        inside = inside[is_in_view(inside, self.camera)]
        if len(inside) == 0:
            return None
        return self._clip_to_image(self.camera.pixels_from_points(inside), self.lens.blooming.margin)

    def _clip_to_image(self, pixels: NDArray[np.float64], margin: float) -> Window | None:
        """Return rows and columns about pixels, shape (n, 2), with a margin [px], clipped to the image."""
        size = np.array([self.camera.width, self.camera.height])
        left, top = np.clip(np.floor(pixels.min(axis=0) - margin), 0, size).astype(int).tolist()
        right, bottom = np.clip(np.ceil(pixels.max(axis=0) + margin) + 1, 0, size).astype(int).tolist()
        return (slice(top, bottom), slice(left, right)) if left < right and top < bottom else None
