"""How well the dots that a pose rests on were measured, and what pose their noise allows at best.

The truth comes from the renderer. The Cramér-Rao bound is that of `pose_fit`'s unknowns, computed another way:
the camera that photographs is moved by each unknown, and the chips' pixels are differenced.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from _floor_photographs import Photograph, true_mount
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floor_localizer.core.fix import Fix
from scene_simulator.dot_floor import DotFloor
from scene_simulator.floor_camera import FloorCamera
from shirube_core.geometry import SE2

ALONE = 1.3
"""A chip is isolated when no other centre is nearer than this multiple of the mean of both diameters."""

_STEPS = np.array([1e-5, 1e-5, 1e-4, 1e-4, 1e-4, 1e-4])
_GROUPS = 4


@dataclass(frozen=True)
class DotNoise:
    """The n matched dots of one view.

    Attributes:
        errors: shape (n, 2), centroids less these [px].
        sigmas: shape (n,), as the detector states them [px].
        alone: shape (n,), chips that touch no other.
        jacobian: shape (n, 2, 6), of the pixels by x, y, yaw, scale, roll, pitch.
        map_covariances: shape (n, 2, 2), of the map's dots, seen in the image [px^2].
    """

    errors: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    alone: NDArray[np.bool_]
    jacobian: NDArray[np.float64]
    map_covariances: NDArray[np.float64]


def dot_noise(
    floor: DotFloor, tree: cKDTree, camera: FloorCamera, photograph: Photograph, fix: Fix, survey_error: float
) -> DotNoise:
    """Measure the matched dots of a view against the rendered truth.

    Args:
        floor: the true floor.
        tree: k-d tree of its chips' centres.
        camera: that took the photograph.
        photograph: the photograph and its true pose.
        fix: the pose found.
        survey_error: standard deviation of the dots in the map [m].
    """
    chips = np.asarray(tree.query(fix.map_points[fix.matched])[1])
    points = floor.points[chips]
    mount = true_mount(photograph.sway)
    pixels = camera.project(points, photograph.T_map_base, mount)
    distances, others = map(np.asarray, tree.query(points, k=2))
    jacobian = _jacobian(camera, points, photograph)
    # An error of a dot's map position moves it in the image like an error of the robot's pose.
    by_place = jacobian[:, :, :2]
    means = 0.5 * (floor.diameters[chips] + floor.diameters[others[:, 1]])
    return DotNoise(
        fix.dots.pixels[fix.matched] - pixels,
        fix.dots.sigmas[fix.matched],
        distances[:, 1] > ALONE * means,
        jacobian,
        survey_error**2 * by_place @ by_place.transpose(0, 2, 1),
    )


def _jacobian(
    camera: FloorCamera, points: NDArray[np.float64], photograph: Photograph
) -> NDArray[np.float64]:
    """Return how the pixels of floor points move with each unknown, shape (n, 2, 6), by central differences."""
    pose = photograph.T_map_base
    truth = np.array([pose.x, pose.y, pose.yaw, *photograph.sway])

    def pixels(unknowns: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y, yaw, scale, roll, pitch = (float(unknown) for unknown in unknowns)
        return camera.project(points, SE2(x, y, yaw), true_mount((scale, roll, pitch)))

    columns = [(pixels(truth + step) - pixels(truth - step)) / (2.0 * step.sum()) for step in np.diag(_STEPS)]
    return np.stack(columns, axis=-1)


def planar_bound(noise: DotNoise, sigmas: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the Cramér-Rao bound of x, y and yaw, shape (3, 3), for centroids with these sigmas, (n,) [px]."""
    weights = np.linalg.inv(sigmas[:, None, None] ** 2 * np.eye(2) + noise.map_covariances)
    information = np.einsum('nia,nij,njb->ab', noise.jacobian, weights, noise.jacobian)
    return np.asarray(np.linalg.inv(information)[:3, :3])


def true_sigmas(views: Sequence[DotNoise]) -> list[NDArray[np.float64]]:
    """Return the deviations that the centroids of each view really had, measured over all views [px].

    Dots that stand alone and dots that touch are sorted into groups by the deviation that the detector states;
    the rms error of a group is that of its dots.
    """
    alone = np.concatenate([view.alone for view in views])
    stated = np.concatenate([view.sigmas for view in views])
    squares = np.concatenate([np.mean(view.errors**2, axis=1) for view in views])
    found = np.empty(len(stated))
    for kind in (alone, ~alone):
        members = np.flatnonzero(kind)
        for group in np.array_split(members[np.argsort(stated[members], kind='stable')], _GROUPS):
            found[group] = math.sqrt(np.mean(squares[group])) if len(group) else math.nan
    return np.split(found, np.cumsum([len(view.sigmas) for view in views])[:-1])
