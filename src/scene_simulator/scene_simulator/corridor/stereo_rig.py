"""A stereo rig on a robot, and its calibration as camera_calibration reports it."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from scene_simulator.corridor.painting import SAMPLES, Texture, paint_outline, plaster
from scene_simulator.corridor.scene import project_outline, view_planes
from scene_simulator.corridor.shapes import PaintedScene
from scene_simulator.imaging.exposure import CameraPose, camera_pose
from scene_simulator.imaging.sensors import GainSensor
from shirube_core.geometry import SE2, CameraMount, PinholeCamera, matrix_from_rpy

_UNITS = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))


@dataclass(frozen=True)
class StereoOptics:
    """What the lens and the motion do to the light.

    Attributes:
        blur: standard deviation of the point-spread function [px]; a lens out of focus has more.
        motion_blur: image motion during the exposure, right and down [px].
        vignetting: fraction of the light that is missing in the corners.
    """

    blur: float = 0.6
    motion_blur: tuple[float, float] = (0.0, 0.0)
    vignetting: float = 0.15

    def spread(self, light: NDArray[np.float32], scale: int) -> NDArray[np.float32]:
        """Return light, shape (height, width), as lens and motion blur it, with ``scale`` samples a pixel each way."""
        if self.blur > 0.0:
            light = cv2.GaussianBlur(light, (0, 0), scale * self.blur, borderType=cv2.BORDER_REPLICATE)
        if any(self.motion_blur):
            light = cv2.filter2D(light, -1, _motion_kernel(self.motion_blur, scale), borderType=cv2.BORDER_REPLICATE)
        return np.asarray(light, dtype=np.float32)


@dataclass(frozen=True)
class StereoCamera:
    """A camera: pinhole and distortion, blur and vignetting, gain and noise."""

    intrinsics: PinholeCamera
    optics: StereoOptics = field(default_factory=StereoOptics)
    sensor: GainSensor = field(default_factory=GainSensor)

    def photograph(
        self, scene: PaintedScene, pose: CameraPose, rng: np.random.Generator | None = None
    ) -> NDArray[np.uint8]:
        """Return a picture, shape (height, width), from ``T_map_camera``; without a source of noise it has none."""
        return self.sensor.expose(self.light(scene, pose), rng)

    def light(self, scene: PaintedScene, pose: CameraPose) -> NDArray[np.float32]:
        """Return the light that the pixels collect, shape (height, width), 1 fills the well."""
        table, camera = scene.table, self.intrinsics
        homographies = np.array([_homography_from_rays(surface.points_map(_UNITS), pose) for surface in table.surfaces])
        lamps = np.array([(*scene.light.on_surface(s), 1.0 / camera.fx) for s in table.surfaces])
        # The back of a surface, painted first, would shine through the edges of what is painted over it.
        faces = [(pose.position - surface.origin) @ surface.normal > 0.0 for surface in table.surfaces]
        light = np.zeros((SAMPLES * camera.height, SAMPLES * camera.width), dtype=np.float32)
        lens = np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion])
        grain = plaster()
        _paint_all(
            light,
            self._rays,
            (pose.camera_points(table.points), table.starts, table.surface_of, table.paints),
            (homographies.reshape(-1, 3, 3), lamps.reshape(-1, 4), np.array(faces, dtype=np.bool_)),
            (self._view, lens, (camera.width, camera.height)),
            (grain.samples, grain.starts, grain.sizes),
        )
        spread = self.optics.spread(light, SAMPLES)
        pixels = cv2.resize(spread, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
        return np.asarray(pixels * self._transmission, dtype=np.float32)

    @cached_property
    def _rays(self) -> NDArray[np.float32]:
        """Undistorted rays of the pixels, shape (height, width, 2), z = 1."""
        v, u = np.mgrid[: self.intrinsics.height, : self.intrinsics.width]
        rays = self.intrinsics.rays_from_pixels(np.column_stack([u.ravel(), v.ravel()]))
        return np.ascontiguousarray(rays[:, :2].reshape(*u.shape, 2), dtype=np.float32)

    @cached_property
    def _view(self) -> NDArray[np.float64]:
        """Half spaces that hold all that the camera sees, shape (5, 4)."""
        return view_planes(self._rays.astype(np.float64))

    @cached_property
    def _transmission(self) -> NDArray[np.float32]:
        """Fraction of the light that passes the lens, shape (height, width)."""
        u = np.linspace(-1.0, 1.0, self.intrinsics.width)[None, :]
        v = np.linspace(-1.0, 1.0, self.intrinsics.height)[:, None]
        return np.asarray(1.0 - 0.5 * self.optics.vignetting * (u**2 + v**2), dtype=np.float32)


def _homography_from_rays(frame: NDArray[np.float64], pose: CameraPose) -> NDArray[np.float64]:
    """Return the homography, shape (3, 3), from rays to places on a plane: its origin and the ends of its axes."""
    origin, right, up = pose.camera_points(frame)
    rays_from_plane = np.column_stack([right - origin, up - origin, origin])
    # A camera in the plane sees nothing of it.
    if abs(np.linalg.det(rays_from_plane)) < 1e-9:
        return np.eye(3)
    return np.asarray(np.linalg.inv(rays_from_plane))


def _motion_kernel(motion_blur: tuple[float, float], scale: int) -> NDArray[np.float32]:
    """Return the kernel of an even motion; its points are shared among the samples around them."""
    reach = int(np.ceil(0.5 * scale * max(map(abs, motion_blur)))) + 1
    kernel = np.zeros((2 * reach + 1, 2 * reach + 1))
    for fraction in (np.arange(64) + 0.5) / 64 - 0.5:
        x, y = reach + fraction * scale * motion_blur[0], reach + fraction * scale * motion_blur[1]
        i, j = int(x), int(y)
        u, v = x - i, y - j
        kernel[j : j + 2, i : i + 2] += np.outer((1.0 - v, v), (1.0 - u, u))
    return np.asarray(kernel / kernel.sum(), dtype=np.float32)


@njit(cache=True, error_model='numpy')
def _paint_all(
    light: NDArray[np.float32],
    rays: NDArray[np.float32],
    shapes: tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]],
    surfaces: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]],
    view: tuple[NDArray[np.float64], NDArray[np.float64], tuple[int, int]],
    texture: Texture,
) -> None:
    """Paint shapes one after the other on a picture, those whose plane turns its front to the camera."""
    points, starts, surface_of, paints = shapes
    planes, lens, size = view
    sums = np.zeros((light.shape[0], light.shape[1] + 2), dtype=np.float32)
    for shape in range(len(starts) - 1):
        surface = surface_of[shape]
        if not surfaces[2][surface]:
            continue
        outline = points[starts[shape] : starts[shape + 1]]
        seen = project_outline(outline, planes, lens, size, SAMPLES)
        if len(seen) >= 3:
            shading = (paints[shape], surfaces[0][surface], surfaces[1][surface])
            paint_outline(light, sums, seen, rays, shading, texture)


FORWARD_MOUNT = CameraMount((0.1, 0.12, 1.25), (-math.pi / 2.0, 0.0, -math.pi / 2.0))
"""The left camera: it looks along the robot's x axis, level, on a mast."""

RECTIFIED = StereoCamera(PinholeCamera(752, 480, 720.0, 720.0, 375.5, 239.5))


@dataclass(frozen=True)
class CameraCalibration:
    """``camera_calibration`` result for one camera of a pair.

    Attributes:
        camera: intrinsics of the images as they come.
        rotation: shape (3, 3), from the camera's optical frame to the rectified one.
        projection: shape (3, 4), from the left camera's rectified frame into the rectified image; the right camera
            has -fx * baseline at [0, 3] [px m].
    """

    camera: PinholeCamera
    rotation: NDArray[np.float64]
    projection: NDArray[np.float64]


@dataclass(frozen=True)
class StereoRig:
    """Two cameras.

    Attributes:
        left: the left camera.
        right: the right one.
        right_xyz: place of the right camera in the left one's optical frame [m]; x is close to the baseline.
        right_rpy: its fixed-axis turn against the left one [rad]; none for images that are rectified already.
        mount: the left camera's optical frame on the robot.
    """

    left: StereoCamera = RECTIFIED
    right: StereoCamera = field(
        default_factory=lambda: StereoCamera(RECTIFIED.intrinsics, sensor=GainSensor(gain=0.97))
    )
    right_xyz: tuple[float, float, float] = (0.24, 0.0, 0.0)
    right_rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mount: CameraMount = FORWARD_MOUNT

    @property
    def baseline(self) -> float:
        """Distance of the cameras [m]."""
        return math.hypot(*self.right_xyz)

    def camera_poses(self, T_map_base: SE2) -> tuple[CameraPose, CameraPose]:
        """Return ``T_map_left`` and ``T_map_right``."""
        left = camera_pose(T_map_base, self.mount)
        position = left.position + left.rotation @ self.right_xyz
        return left, CameraPose(position, left.rotation @ matrix_from_rpy(self.right_rpy))

    @property
    def is_rectified(self) -> bool:
        """Lenses do not distort, rows are the same in both images."""
        distortion = (*self.left.intrinsics.distortion, *self.right.intrinsics.distortion)
        return not any((*distortion, *self.right_rpy, *self.right_xyz[1:]))

    def calibrations(self) -> tuple[CameraCalibration, CameraCalibration]:
        """Return the exact calibration of the left and the right camera; rectified images keep their camera matrix."""
        left, right = self.left.intrinsics, self.right.intrinsics
        if self.is_rectified:
            shifts = np.zeros((3, 1)), np.array([[-right.fx * self.baseline], [0.0], [0.0]])
            P1, P2 = (np.hstack([camera.matrix, s]) for camera, s in zip((left, right), shifts, strict=True))
            return CameraCalibration(left, np.eye(3), P1), CameraCalibration(right, np.eye(3), P2)
        R_right_left = matrix_from_rpy(self.right_rpy).T
        R1, R2, P1, P2 = cv2.stereoRectify(
            left.matrix,
            np.array(left.distortion),
            right.matrix,
            np.array(right.distortion),
            (left.width, left.height),
            R_right_left,
            -R_right_left @ np.array(self.right_xyz).reshape(3, 1),
            flags=cv2.CALIB_ZERO_DISPARITY,
            alpha=0.0,
        )[:4]
        return CameraCalibration(left, R1, P1), CameraCalibration(right, R2, P2)


def raw_rig() -> StereoRig:
    """Return an unrectified rig: two slightly different distorting lenses, not quite parallel."""
    left = PinholeCamera(752, 480, 722.3, 721.6, 371.2, 243.8, (-0.281, 0.083, 0.0004, -0.0003, 0.0))
    right = PinholeCamera(752, 480, 719.1, 718.8, 380.4, 236.9, (-0.274, 0.077, -0.0005, 0.0002, 0.0))
    rpy = (math.radians(0.35), math.radians(-0.5), math.radians(0.25))
    return StereoRig(
        StereoCamera(left), StereoCamera(right, sensor=GainSensor(gain=0.97)), (0.2395, -0.0011, 0.0016), rpy
    )


def render_pair(
    scene: PaintedScene, rig: StereoRig, T_map_base: SE2, rng: np.random.Generator | None = None
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the pictures of the left and the right camera at a pose of the robot, each of shape (height, width).

    For a robot that leans, the mount is in the upright frame under it. Without a source of noise there is none.
    """
    left, right = rig.camera_poses(T_map_base)
    return rig.left.photograph(scene, left, rng), rig.right.photograph(scene, right, rng)
