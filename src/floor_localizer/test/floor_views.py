"""Random floors and simulated views of them, with an independent camera model: rotations and projected points."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from floor_localizer.core.dots import DetectedDots, DotMap
from floor_localizer.core.fix import Fix
from shirube_core.geometry import SE2, CameraMount, PinholeCamera, matrix_from_rpy

DENSITY = 5384.0
SIZE = (0.95, 0.6)
CAMERA = PinholeCamera(235, 235, 339.44, 339.44, 117.0, 117.0)
MOUNT = CameraMount(xyz=(0.05, -0.02, 0.13))


@dataclass(frozen=True)
class View:
    """Dots in an image, with the index of each dot's map dot, -1 for spurious dots."""

    dots: DetectedDots
    sources: NDArray[np.int64]


def random_floor(seed: int, size: tuple[float, float] = SIZE, density: float = DENSITY) -> DotMap:
    rng = np.random.default_rng(seed)
    points = rng.uniform((0.0, 0.0), size, (round(density * size[0] * size[1]), 2))
    crowded = cKDTree(points).query_pairs(0.001, output_type='ndarray')
    points = np.delete(points, np.unique(crowded[:, 0]), axis=0)
    return DotMap(points, np.full(len(points), 0.0025))


def pose_over(rng: np.random.Generator, size: tuple[float, float] = SIZE, mount: CameraMount = MOUNT) -> SE2:
    """A random pose whose view is completely on the floor."""
    at_camera = SE2(*rng.uniform(0.08, np.array(size) - 0.08), rng.uniform(-math.pi, math.pi))
    return at_camera @ SE2(*mount.xyz[:2], 0.0).inverse()


def see(
    floor: DotMap,
    T_map_base: SE2,
    rng: np.random.Generator,
    *,
    noise: float = 0.1,
    scale: float = 0.0,
    tilt: tuple[float, float] = (0.0, 0.0),
    missing: float = 0.0,
    spurious: int = 0,
    mount: CameraMount = MOUNT,
    camera: PinholeCamera = CAMERA,
) -> View:
    """The camera's view from a robot with a relative height error and a tilt (roll, pitch)."""
    body = matrix_from_rpy((*tilt, 0.0))
    centre = body @ mount.xyz + (0.0, 0.0, scale * mount.xyz[2])
    base = np.column_stack([T_map_base.inverse().transform(floor.points), np.zeros(len(floor))])
    seen = (base - centre) @ (body @ mount.rotation)
    ahead = np.flatnonzero(seen[:, 2] > 0.01)
    pixels = camera.pixels_from_points(seen[ahead])
    inside = np.all((pixels > 0.0) & (pixels < (camera.width - 1.0, camera.height - 1.0)), axis=1)
    inside &= rng.uniform(size=len(inside)) >= missing
    pixels = pixels[inside] + rng.normal(0.0, 1.0, (inside.sum(), 2)) * noise
    false = rng.uniform(0.0, (camera.width - 1.0, camera.height - 1.0), (spurious, 2))
    order = rng.permutation(len(pixels) + spurious)
    sources = np.concatenate([ahead[inside], np.full(spurious, -1)])[order]
    return View(dots_at(np.vstack([pixels, false])[order], max(noise, 0.05)), sources)


def dots_at(pixels: ArrayLike, sigma: float = 0.1) -> DetectedDots:
    pixels = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
    return DetectedDots(pixels, np.full(len(pixels), 6.5), np.full(len(pixels), sigma))


def first_dots(dots: DetectedDots, number: int) -> DetectedDots:
    return replace(dots, pixels=dots.pixels[:number], diameters=dots.diameters[:number], sigmas=dots.sigmas[:number])


def mirrored(dots: DetectedDots, camera: PinholeCamera = CAMERA) -> DetectedDots:
    return replace(dots, pixels=np.column_stack([camera.width - 1.0 - dots.pixels[:, 0], dots.pixels[:, 1]]))


def is_right(fix: object, truth: SE2, position: float = 0.0005, heading: float = 0.01) -> bool:
    """Whether a result is the true pose."""
    if not isinstance(fix, Fix):
        return False
    found = fix.T_map_base
    return found.distance_to(truth) < position and abs(found.yaw_to(truth)) < heading
