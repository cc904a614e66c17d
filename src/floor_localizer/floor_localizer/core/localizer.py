"""Pose of a robot from one image of the floor under it.

The steps of Fukase & Kanamori, each with a faster or safer method:

1. detect the dots of the image and project them to the floor (3.1);
2. generate hypotheses: near the prior if there is one, else by geometric hashing of constellations (2.2, in place of
   the pole-star table), else by matching pairs of dots to the whole map;
3. match the whole view and test its significance (2.3.3, with a computed bound instead of a tuned threshold);
4. fit the pose to all matched dots by least squares, with the camera's height and the robot's tilt.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.constellation.acceptance import (
    AMBIGUITY_FRACTION,
    SearchState,
    is_accepted,
    new_search,
)
from floor_localizer.core.constellation.constellation_search import search_constellations
from floor_localizer.core.constellation.indexed_map import IndexedMap
from floor_localizer.core.constellation.pair_search import search_near, search_pairs
from floor_localizer.core.constellation.view_dots import ViewDots, make_view, mirror_view
from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.dots import DetectedDots, FloorPoints, merge_points
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.fix import Fix, NoFix, NoFixReason, PosePrior
from floor_localizer.core.levels import level_at
from floor_localizer.core.pose_fit import MountedRays, refine_pose
from floor_localizer.core.settings import LocalizerSettings
from shirube_core.geometry import SE2, CameraMount, PinholeCamera, wrap_angle

_MIN_DOTS = 5
_PRIOR_PAIRS = 12
_MIRROR_CELLS = 40000
# Priors with a larger radius [m] are searched with the whole map.
_MAX_PRIOR_RADIUS = 0.5


class FloorLocalizer:
    """Finds the pose of a robot on one floor. Has no state between images."""

    def __init__(
        self,
        floor: IndexedMap,
        mount: CameraMount,
        settings: LocalizerSettings | None = None,
        detector: DotDetector | None = None,
    ) -> None:
        """Create a localizer.

        Args:
            floor: the floor's dots, indexed by `index_map`.
            mount: pose of the camera on the robot.
            settings: settings of the matching, None for the defaults.
            detector: dot detector, None for the default one.

        Raises:
            FloorLocalizerError: a camera that does not look at the floor.
        """
        check_mount(mount)
        self._floor = floor
        self._mount = mount
        self._settings = settings or LocalizerSettings()
        self._detector = detector or DotDetector()

    def locate(
        self, image: NDArray[np.uint8], camera: PinholeCamera, prior: PosePrior | None = None
    ) -> Fix | NoFix:
        """Find the pose from an image, on a map of several levels in the frame of its level.

        Args:
            image: shape (h, w) grey or (h, w, 3) blue, green, red.
            camera: the camera's intrinsics, for images of this size.
            prior: expected pose on the whole map, if known.

        Raises:
            DotImageError: the image is of another type or shape.
        """
        return self.to_level(self.locate_dots(self.detect(image), camera, prior))

    def to_level(self, result: Fix | NoFix) -> Fix | NoFix:
        """Return a result of `locate_dots` in the frame of the robot's level, if the map has levels."""
        if isinstance(result, NoFix):
            return result
        level = level_at(self._floor.levels, result.T_map_base.x, result.T_map_base.y)
        if level is None:
            return result
        return replace(
            result,
            T_map_base=level.to_level(result.T_map_base),
            map_points=result.map_points - level.offset,
            level=level.name,
        )

    def to_map(self, pose: SE2, level: str) -> SE2:
        """Transform a pose from the frame of a level to the whole map.

        Args:
            pose: pose in the frame of the level.
            level: name of the level; empty for a map without levels.

        Raises:
            FloorLocalizerError: the map has no such level.
        """
        levels = {each.name: each for each in self._floor.levels}
        if not level and not levels:
            return pose
        if level not in levels:
            known = ', '.join(levels) or 'none'
            raise FloorLocalizerError(f'the map has no level {level!r}; it has: {known}')
        return levels[level].to_map(pose)

    def detect(self, image: NDArray[np.uint8]) -> DetectedDots:
        """Detect the dots of an image; argument and errors as for `locate`."""
        return self._detector.detect(image)

    def floor_points(self, dots: DetectedDots, camera: PinholeCamera) -> FloorPoints:
        """Project dots to the floor, for the camera as mounted; dots above the horizon are dropped."""
        return self._project_to_floor(dots, camera)[1]

    def _project_to_floor(
        self, dots: DetectedDots, camera: PinholeCamera
    ) -> tuple[DetectedDots, FloorPoints]:
        """Return the dots below the horizon and their positions on the floor."""
        points = self._mount.floor_points_from_rays(camera.rays_from_pixels(dots.pixels))
        is_visible = np.isfinite(points).all(axis=1)
        dots = DetectedDots(dots.pixels[is_visible], dots.diameters[is_visible], dots.sigmas[is_visible])
        metres_per_pixel = self._mount.xyz[2] / math.sqrt(camera.fx * camera.fy)
        return dots, FloorPoints(
            points[is_visible], np.hypot(dots.sigmas * metres_per_pixel, self._settings.map_sigma)
        )

    def locate_dots(
        self,
        dots: DetectedDots,
        camera: PinholeCamera,
        prior: PosePrior | None = None,
        *,
        earlier: FloorPoints | None = None,
        effort: float = 1.0,
    ) -> Fix | NoFix:
        """Find the pose on the whole map from the dots of an image.

        Args:
            dots: the dots, in coordinates of the raw image.
            camera: the camera's intrinsics.
            prior: expected pose on the whole map, if known.
            earlier: dots of earlier views in the current base frame, used in addition.
            effort: fraction of the search budgets of the settings to spend.
        """
        dots, points = self._project_to_floor(dots, camera)
        if len(dots) == 0:
            return NoFix(NoFixReason.NO_DOTS, 'no dots detected in the image', dots)
        if earlier is not None:
            points = merge_points(earlier, points)
        if len(points.points) < _MIN_DOTS:
            return NoFix(NoFixReason.TOO_FEW_DOTS, f'{len(dots)} dots, at least {_MIN_DOTS} are needed', dots)
        view = self._make_view(points)
        search, used_prior = self._search(view, prior, effort)
        if not is_accepted(search, search.best):
            return self._explain_failure(view, search, dots, used_prior, effort)
        poses = [search.best] if used_prior else _plausible_poses(search)
        if prior is not None and prior.is_strict:
            poses = [pose for pose in poses if _is_in_area(pose, prior)]
        if not poses:
            return NoFix(NoFixReason.OUTSIDE_AREA, _describe_pose(search.best), dots)
        if len(poses) > 1:
            return NoFix(NoFixReason.AMBIGUOUS, ' and '.join(map(_describe_pose, poses)), dots)
        return self._refine_pose(points, poses[0], dots, used_prior)

    def _make_view(self, points: FloorPoints) -> ViewDots:
        return make_view(
            points.points,
            float(np.sqrt(np.mean(points.sigmas**2))),
            self._settings.tilt_tolerance / self._mount.xyz[2],
            self._settings.scale_tolerance,
            self._floor.density,
        )

    def _search(self, view: ViewDots, prior: PosePrior | None, effort: float) -> tuple[SearchState, bool]:
        """Search near the prior, then on the whole map unless the prior is strict."""
        settings, floor = self._settings, self._floor
        if prior is not None and prior.radius <= _MAX_PRIOR_RADIUS:
            search = self._new_search(view, _count_candidate_dots(floor, prior))
            expected = np.array([prior.T_map_base.x, prior.T_map_base.y, prior.T_map_base.yaw])
            if search_near(
                floor.grid, view, search, expected, prior.radius, prior.yaw_tolerance, _PRIOR_PAIRS
            ):
                return search, True
            if prior.is_strict:
                return search, True
        search = self._new_search(view, float(len(floor.grid.points)))
        cells, pairs = int(effort * settings.cells_max), int(effort * settings.pairs_max)
        if not search_constellations(floor.grid, floor.index, view, search, cells):
            search_pairs(floor.grid, floor.addresses, view, search, pairs)
        return search, False

    def _new_search(self, view: ViewDots, candidate_dots: float) -> SearchState:
        settings = self._settings
        return new_search(
            len(view.z), candidate_dots, settings.chance_alignments_max, settings.match_rate_min
        )

    def _refine_pose(
        self, points: FloorPoints, pose: NDArray[np.float64], dots: DetectedDots, used_prior: bool
    ) -> Fix | NoFix:
        """Fit the full model, starting from a pose of the search."""
        settings, start = self._settings, _upright_state(pose, self._mount)
        # Standard deviation of the uniform distribution: tolerance over sqrt(3).
        priors = np.array(
            [settings.scale_tolerance, settings.tilt_tolerance, settings.tilt_tolerance]
        ) / math.sqrt(3.0)
        rays = self._mount.camera_points_from_floor(points.points)
        mounted = MountedRays(rays, self._mount.rotation, np.array(self._mount.xyz))
        state, covariance, matches = refine_pose(self._floor.grid, mounted, points.sigmas, start, priors)
        matched = matches >= 0
        match_rate = float(np.mean(matched))
        if match_rate < settings.match_rate_min or matched.sum() < 3:
            return NoFix(NoFixReason.UNCERTAIN, f'match rate {match_rate:.0%} after the fit', dots)
        map_points = np.where(matched[:, None], self._floor.grid.points[matches], np.nan)
        return Fix(
            SE2(float(state[0]), float(state[1]), wrap_angle(float(state[2]))),
            covariance[:3, :3],
            dots,
            matched[: len(dots)],
            map_points[: len(dots)],
            match_rate,
            float(state[3]),
            (float(state[4]), float(state[5])),
            math.exp(max(pose[0], -700.0)),
            used_prior,
        )

    def _explain_failure(
        self, view: ViewDots, search: SearchState, dots: DetectedDots, used_prior: bool, effort: float
    ) -> NoFix:
        """Return the reason for no pose."""
        found = f'{search.best[5]:.0f} of {len(dots)} dots match at best'
        if math.isfinite(search.best[0]):
            found += f', expected chance alignments {math.exp(min(search.best[0], 700.0)):.1g}'
        if used_prior:
            return NoFix(NoFixReason.OUTSIDE_AREA, found, dots)
        if search.best[0] < 0.0:
            return NoFix(NoFixReason.UNCERTAIN, found, dots)
        if self._is_mirrored(view, int(effort * _MIRROR_CELLS)):
            return NoFix(NoFixReason.MIRRORED, f'{len(dots)} dots', dots)
        return NoFix(NoFixReason.NO_MATCH, found, dots)

    def _is_mirrored(self, view: ViewDots, cells: int) -> bool:
        """Return whether the mirrored view matches the map, within a budget of index cells."""
        search = self._new_search(view, float(len(self._floor.grid.points)))
        return search_constellations(self._floor.grid, self._floor.index, mirror_view(view), search, cells)


def _upright_state(pose: NDArray[np.float64], mount: CameraMount) -> NDArray[np.float64]:
    """Return the state without tilt, shape (6,), that is equivalent to a pose of the search."""
    a, b = complex(pose[1], pose[2]), complex(pose[3], pose[4])
    scale = abs(a) - 1.0
    # A higher camera scales the view about the point below the camera, but the similarity scales it about the base.
    base = b + scale * a / abs(a) * complex(mount.xyz[0], mount.xyz[1])
    return np.array([base.real, base.imag, math.atan2(a.imag, a.real), scale, 0.0, 0.0])


def _plausible_poses(search: SearchState) -> list[NDArray[np.float64]]:
    """Return the best pose of a search, and the runner-up if it is about as good."""
    runner_up = search.runner_up
    is_ambiguous = is_accepted(search, runner_up) and runner_up[5] >= AMBIGUITY_FRACTION * search.best[5]
    return [search.best, runner_up] if is_ambiguous else [search.best]


def _describe_pose(pose: NDArray[np.float64]) -> str:
    return f'{pose[5]:.0f} dots match at ({pose[3]:.2f}, {pose[4]:.2f}) m'


def _is_in_area(pose: NDArray[np.float64], prior: PosePrior) -> bool:
    """Return whether a pose of the search is within the prior."""
    found = SE2(float(pose[3]), float(pose[4]), math.atan2(pose[2], pose[1]))
    expected = prior.T_map_base
    return found.distance_to(expected) <= prior.radius and abs(found.yaw_to(expected)) <= prior.yaw_tolerance


def _count_candidate_dots(floor: IndexedMap, prior: PosePrior) -> float:
    """Return the expected number of map dots within the prior, weighted by its range of yaw."""
    area = math.pi * (prior.radius + floor.grid.cell) ** 2
    return max(floor.density * area * min(prior.yaw_tolerance / math.pi, 1.0), 1.0)


# Smallest sine of the angle by which the optical axis points below the horizon.
_MIN_SLOPE = 0.1


def check_mount(mount: CameraMount) -> None:
    """Reject a camera below the floor or one that does not look at it.

    Raises:
        FloorLocalizerError: invalid mount; the message names the parameter and the remedy.
    """
    height = mount.xyz[2]
    if height <= 0.0:
        raise FloorLocalizerError(
            f'camera_xyz: z is {height:g} m, it must be above the floor, which is the plane z = 0 of base_frame'
        )
    if -mount.rotation[2, 2] < _MIN_SLOPE:
        raise FloorLocalizerError(
            f'camera_rpy: {", ".join(f"{angle:g}" for angle in mount.rpy)} rad does not look at the floor; '
            f'{", ".join(f"{angle:.4f}" for angle in CameraMount().rpy)} looks straight down'
        )
