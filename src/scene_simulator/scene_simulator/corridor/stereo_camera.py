"""One camera of a stereo rig: from the shapes of a corridor to grey levels."""

from dataclasses import dataclass, field
from functools import cached_property

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from scene_simulator.corridor.painting import SAMPLES, Texture, paint_outline, plaster
from scene_simulator.corridor.projection import project_outline, view_planes
from scene_simulator.corridor.shapes import PaintedScene
from scene_simulator.imaging.exposure import CameraPose
from scene_simulator.imaging.sensors import GainSensor
from shirube_core.geometry import PinholeCamera

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
    """A camera.

    Attributes:
        intrinsics: pinhole and distortion.
        optics: blur and vignetting.
        sensor: gain and noise.
    """

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
