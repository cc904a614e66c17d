"""The paper's positioning from lamp sizes, equations (2) to (7): corrected, and as printed.

The depth of a lamp follows from its radius in the image, the camera's position from depth and ray, and an interval for
it from the quantization of the radius; the result is the centre of the intersection of all intervals. Yaw is given.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2, SE3, PinholeCamera
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_fix import BeaconFix, NoBeaconFix, NoFixReason

RADIUS_STEP = 0.5
"""Quantization step of radii in the paper [px]; the error is at most half a step."""
CENTRE_SIGMAS = 3.0
OUTLINE_POINTS = 64


@dataclass(frozen=True)
class LampDiscs:
    """Lamps in an image with their radii.

    Attributes:
        beacons: known lamps, n.
        pixels: lamp centres, shape (n, 2) [px].
        radii: lamp radii without blooming, those of circles of equal area, shape (n,) [px].
        sigma: standard deviation of the centres [px].
    """

    beacons: Sequence[Beacon]
    pixels: NDArray[np.float64]
    radii: NDArray[np.float64]
    sigma: float = 0.2

    @property
    def lamp_positions(self) -> NDArray[np.float64]:
        """Positions of the lamps in the map, shape (n, 3) [m]."""
        return np.array([beacon.xyz for beacon in self.beacons])

    @property
    def lamp_radii(self) -> NDArray[np.float64]:
        """Radii of the lamps, shape (n,) [m]."""
        return np.array([beacon.radius for beacon in self.beacons])

    def undistorted(self, camera: PinholeCamera) -> LampDiscs:
        """Return the discs in the image of a camera with the same K and no distortion (section 3.1).

        The outline of each disc is undistorted; its area and centroid give the new disc. Discs beyond the valid range
        of the lens model are dropped.
        """
        if not camera.has_distortion:
            return self
        angles = 2.0 * math.pi / OUTLINE_POINTS * np.arange(OUTLINE_POINTS)
        circle = np.column_stack([np.cos(angles), np.sin(angles)])
        outlines = self.pixels[:, None] + self.radii[:, None, None] * circle
        rays = camera.rays_from_pixels(outlines.reshape(-1, 2))[:, :2].reshape(outlines.shape)
        valid = np.flatnonzero(np.isfinite(rays).all(axis=(1, 2))).tolist()
        beacons = [self.beacons[i] for i in valid]
        rays, outlines, radii = rays[valid], outlines[valid], self.radii[valid]
        centres, areas = _polygon_centroids(rays * (camera.fx, camera.fy) + (camera.cx, camera.cy))
        scales = np.sqrt(areas / _polygon_centroids(outlines)[1])
        return LampDiscs(beacons, centres, radii * scales, self.sigma * float(scales.max(initial=1.0)))


def _polygon_centroids(outlines: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return centroids, shape (n, 2), and areas, shape (n,), of polygons with k corners, shape (n, k, 2)."""
    middles = outlines.mean(axis=1)
    corners = outlines - middles[:, None]  # for the precision
    following = np.roll(corners, -1, axis=1)
    cross = corners[..., 0] * following[..., 1] - corners[..., 1] * following[..., 0]
    areas = 0.5 * cross.sum(axis=1)
    moments = ((corners + following) * cross[..., None]).sum(axis=1)
    return middles + moments / (6.0 * areas)[:, None], np.abs(areas)


def radius_interval(discs: LampDiscs, camera: PinholeCamera, level_camera: SE3, yaw: float) -> BeaconFix | NoBeaconFix:
    """Return the pose by the paper's method with its equations corrected.

    Args:
        discs: lamps in view.
        camera: camera intrinsics.
        level_camera: gravity-aligned camera pose on the robot.
        yaw: yaw of the base [rad].
    """
    # Section 3.1: the distortion is corrected first.
    discs = discs.undistorted(camera)
    if len(discs.beacons) == 0:
        return NoBeaconFix(NoFixReason.NO_LAMP, 'no lamp of the file is in view')
    # Eqs (1) and (2): R K^-1 (u, v, 1). The focal length lacks a factor 1/2 in the paper; K is from CameraInfo.
    rays = np.column_stack([discs.pixels, np.ones(len(discs.pixels))]) @ np.linalg.inv(camera.matrix).T
    rays = rays @ (_yaw_rotation(yaw) @ level_camera.rotation).T
    # Eq. (3): z = r f / (p rho), the depth along the optical axis.
    sizes = discs.lamp_radii * math.sqrt(camera.fx * camera.fy)
    depths = sizes / discs.radii
    # Eq. (5) with a minus: the camera is below the lamp.
    camera_positions = discs.lamp_positions - depths[:, None] * rays
    # Eq. (6) with positive sign, half as wide and projected on the ray; and the noise of the centre.
    quarter = 0.5 * RADIUS_STEP
    nearest, farthest = sizes / (discs.radii + quarter), sizes / np.maximum(discs.radii - quarter, 0.1)
    half_width = 0.5 * (farthest - nearest)[:, None] * np.abs(rays)
    half_width += CENTRE_SIGMAS * discs.sigma * (depths / camera.fx)[:, None]
    # Eq. (7): the centre of the intersection of all intervals, which must not be empty.
    low, high = (camera_positions - half_width).max(axis=0), (camera_positions + half_width).min(axis=0)
    if (low > high).any():
        names = ', '.join(str(beacon.id) for beacon in discs.beacons)
        detail = f'the intervals of lamps {names} are {float((low - high).max()):.3f} m apart'
        return NoBeaconFix(NoFixReason.INCONSISTENT, detail)
    return _make_fix(0.5 * (low + high), 0.5 * (high - low), level_camera, yaw, len(depths))


def radius_interval_printed(
    discs: LampDiscs, camera: PinholeCamera, level_camera: SE3, yaw: float, focal_scale: float = 2.0
) -> BeaconFix | NoBeaconFix:
    """Return the pose by the equations as printed, for comparison only; arguments as in `radius_interval`.

    ``focal_scale`` is the factor of the focal length in eq. (2): 2 as printed, 1 with the missing factor 1/2.
    """
    discs = discs.undistorted(camera)
    if len(discs.beacons) == 0:
        return NoBeaconFix(NoFixReason.NO_LAMP, 'no lamp of the file is in view')
    # Eq. (2): width over the tangent of half the angle of view is twice the focal length.
    focal = focal_scale * np.array([camera.fx, camera.fy])
    centred = (discs.pixels - 0.5 * np.array([camera.width, camera.height])) / focal
    rays = np.column_stack([centred, np.ones(len(centred))]) @ (_yaw_rotation(yaw) @ level_camera.rotation).T
    # Eqs (3), (5) and (6).
    sizes = discs.lamp_radii * camera.fx
    depths = sizes / discs.radii
    camera_positions = discs.lamp_positions + depths[:, None] * rays
    errors = (sizes / (discs.radii + 0.25) - sizes / (discs.radii - 0.25))[:, None]
    # Eq. (7).
    low, high = (camera_positions - errors).max(axis=0), (camera_positions + errors).min(axis=0)
    return _make_fix(0.5 * (low + high), 0.5 * np.abs(high - low), level_camera, yaw, len(depths))


def _yaw_rotation(yaw: float) -> NDArray[np.float64]:
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _make_fix(
    camera_position: NDArray[np.float64], half_width: NDArray[np.float64], level_camera: SE3, yaw: float, count: int
) -> BeaconFix:
    """Return the pose of the base for a camera position, shape (3,), with half-widths of its intervals [m]."""
    base = camera_position - _yaw_rotation(yaw) @ level_camera.position
    covariance = np.diag([*(half_width**2 / 3.0), 0.0])
    used = np.ones(count, dtype=np.bool_)
    pose = SE2(float(base[0]), float(base[1]), yaw)
    return BeaconFix(pose, float(base[2]), covariance, (0.0, 0.0), used, np.zeros((count, 2)))
