"""Pose of a robot from one image of the floor under it.

The steps of Fukase & Kanamori, each with a faster or safer method; the numbers in brackets are sections of the paper.
"""

import cmath
import math
from dataclasses import replace

import numpy as np

from floor_localizer.core.arrays import Floats, Pixels
from floor_localizer.core.constellation.acceptance import (
    ScoredPose,
    SearchState,
    is_accepted,
    new_search,
    score_hypothesis,
)
from floor_localizer.core.constellation.constellation_search import search_constellations
from floor_localizer.core.constellation.indexed_map import IndexedMap
from floor_localizer.core.constellation.pair_search import search_near, search_pairs
from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.dots import (
    DetectedDots,
    FloorPoints,
    ViewDots,
    level_at,
    make_view,
    merge_points,
    mirror_view,
)
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.fix import Fix, NoFix, NoFixReason, PosePrior
from floor_localizer.core.mount_check import check_mount
from floor_localizer.core.pole_star.pole_star_matcher import PoleStarMatcher
from floor_localizer.core.pose_fit import MountedRays, refine_pose
from floor_localizer.core.settings import LocalizerSettings
from shirube_core.geometry import SE2, CameraMount, PinholeCamera, wrap_angle

_MIN_DOTS = 5
_PRIOR_PAIRS = 12
_MIRROR_CELLS = 40000
# Priors with a larger radius [m] are searched with the whole map.
_MAX_PRIOR_RADIUS = 0.5


class FloorLocalizer:
    """Finds the pose of a robot on one ``floor``. Has no state between images."""

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
        self.floor = self._floor = floor
        self._mount = mount
        self._settings, self._detector = settings or LocalizerSettings(), detector or DotDetector()
        self._pole_star = (
            PoleStarMatcher(floor.grid.points.astype(np.float64), self._settings.pole_star)
            if self._settings.matcher == 'pole_star'
            else None
        )

    def locate(self, image: Pixels, camera: PinholeCamera, prior: PosePrior | None = None) -> Fix | NoFix:
        """Find the pose from one image, on a map of several levels in the frame of its level.

        This is the paper in ten steps: step 1 and 10 here, steps 2 to 9 below in `locate_dots`. `FloorTracker.track`,
        which the node calls, runs the same steps for a sequence of images, and says where.

        Args:
            image: shape (h, w) grey or (h, w, 3) blue, green, red.
            camera: the camera's intrinsics, for images of this size.
            prior: expected pose on the whole map, if known.

        Raises:
            DotImageError: the image is of another type or shape.
        """
        # 1. Detect the dots (3.1: smoothing, binarisation, noise removal, labelling) with subpixel centroids.
        dots = self.detect(image)
        # 2 to 9. Match them to the map (2.2 to 2.3.3) and fit the pose.
        result = self.locate_dots(dots, camera, prior)
        # 10. Express the pose in the frame of the robot's level.
        return self.to_level(result)

    def locate_dots(
        self,
        dots: DetectedDots,
        camera: PinholeCamera,
        prior: PosePrior | None = None,
        *,
        earlier: FloorPoints | None = None,
        effort: float = 1.0,
    ) -> Fix | NoFix:
        """Find the pose on the whole map from the dots of an image: steps 2 to 9 of `locate`.

        ``earlier`` are dots of earlier views in the current base frame, used in addition; ``effort`` is the fraction of
        the search budgets of the settings to spend; ``camera`` and ``prior`` are as for `locate`.
        """
        # 2. Project the dots to the floor (3.1: lens distortion) for the camera as mounted; add those of earlier views.
        dots, points = self._project_to_floor(dots, camera)
        if len(dots) == 0:
            return NoFix(NoFixReason.NO_DOTS, 'no dots detected in the image', dots)
        if earlier is not None:
            points = merge_points(earlier, points)
        if len(points.points) < _MIN_DOTS:
            return NoFix(NoFixReason.TOO_FEW_DOTS, f'{len(dots)} dots, at least {_MIN_DOTS} are needed', dots)
        view = self._make_view(points)
        # 3. With a prior (4: a rough area), match pairs of dots to the map dots around their predicted positions.
        search = self._search_near(view, prior)
        used_prior = search is not None
        if search is None:
            # 4. and 5. Else search the whole map, in `_search_whole_map`.
            search = self._search_whole_map(view, effort)
        # 6. The match of the whole view (2.3.3) must be significant: a computed bound instead of a tuned rate (3.3.5).
        if not is_accepted(search, search.best):
            return self._explain_failure(view, search, dots, used_prior, effort)
        # 7. It must be within a strict prior, and
        poses = [search.best] if used_prior else search.plausible_poses()
        if prior is not None and prior.is_strict:
            poses = [pose for pose in poses if prior.contains(pose.pose)]
        if not poses:
            return NoFix(NoFixReason.OUTSIDE_AREA, _describe_pose(search.best), dots)
        # 8. no other place may match about as well (2.3.3: the region with the highest match rate is chosen).
        if len(poses) > 1:
            return NoFix(NoFixReason.AMBIGUOUS, ' and '.join(map(_describe_pose, poses)), dots)
        # 9. Fit the pose to all matched dots (2.3.2), with the camera's height and the robot's tilt.
        return self._refine_pose(points, poses[0], dots, used_prior)

    def detect(self, image: Pixels) -> DetectedDots:
        """Detect the dots of an image: step 1 of `locate`, with its argument and errors."""
        return self._detector.detect(image)

    def _search_near(self, view: ViewDots, prior: PosePrior | None) -> SearchState | None:
        """Search near the prior; None if the whole map must be searched."""
        if prior is None or prior.radius > _MAX_PRIOR_RADIUS:
            return None
        # Expected number of map dots within the prior, weighted by its range of yaw.
        area = math.pi * (prior.radius + self._floor.grid.cell) ** 2
        dots = self._floor.density * area * min(prior.yaw_tolerance / math.pi, 1.0)
        search = self._new_search(view, max(dots, 1.0))
        expected = np.array([prior.T_map_base.x, prior.T_map_base.y, prior.T_map_base.yaw])
        is_found = search_near(
            self._floor.grid, view, search, expected, prior.radius, prior.yaw_tolerance, _PRIOR_PAIRS
        )
        return search if is_found or prior.is_strict else None

    def _search_whole_map(self, view: ViewDots, effort: float) -> SearchState:
        """Search without a prior: steps 4 and 5 of `locate_dots`, or the paper's own."""
        floor, search = self._floor, self._new_search(view, float(len(self._floor.grid.points)))
        if self._pole_star is not None:
            # The paper's own: candidates by their pole stars (2.2), candidate regions (2.3.1), congruent pairs (2.3.2).
            # Their poses are matched to the whole view, as those of steps 4 and 5.
            for each in self._pole_star.congruent_poses(view.points):
                x, y, yaw = each.T_map_view.x, each.T_map_view.y, each.T_map_view.yaw
                score_hypothesis(floor.grid, view, search, cmath.exp(1j * yaw), complex(x, y))
            return search
        cells, pairs = int(effort * self._settings.cells_max), int(effort * self._settings.pairs_max)
        # 4. Look up constellations of six dots in the index of the whole map: geometric hashing, in place of the
        # pole-star table (2.2), the candidate regions (2.3.1) and the congruence (2.3.2).
        if not search_constellations(floor.grid, floor.index, view, search, cells):
            # 5. If none is complete, match pairs of dots to all pairs of the map (2.3.3: matching address matrix).
            search_pairs(floor.grid, floor.addresses, view, search, pairs)
        return search

    def _new_search(self, view: ViewDots, candidate_dots: float) -> SearchState:
        chance, match_rate = self._settings.chance_alignments_max, self._settings.match_rate_min
        return new_search(len(view.z), candidate_dots, chance, match_rate)

    def floor_points(self, dots: DetectedDots, camera: PinholeCamera) -> FloorPoints:
        """Project dots to the floor, for the camera as mounted; dots above the horizon are dropped."""
        return self._project_to_floor(dots, camera)[1]

    def _project_to_floor(self, dots: DetectedDots, camera: PinholeCamera) -> tuple[DetectedDots, FloorPoints]:
        """Return the dots below the horizon and their positions on the floor."""
        points = self._mount.floor_points_from_rays(camera.rays_from_pixels(dots.pixels))
        is_visible = np.isfinite(points).all(axis=1)
        dots = DetectedDots(dots.pixels[is_visible], dots.diameters[is_visible], dots.sigmas[is_visible])
        metres_per_pixel = self._mount.xyz[2] / math.sqrt(camera.fx * camera.fy)
        sigmas = np.hypot(dots.sigmas * metres_per_pixel, self._settings.map_sigma)
        return dots, FloorPoints(points[is_visible], sigmas)

    def _make_view(self, points: FloorPoints) -> ViewDots:
        settings, sigma = self._settings, float(np.sqrt(np.mean(points.sigmas**2)))
        tilt_rate = settings.tilt_tolerance / self._mount.xyz[2]
        return make_view(points.points, sigma, tilt_rate, settings.scale_tolerance, self._floor.density)

    def _refine_pose(self, points: FloorPoints, start: ScoredPose, dots: DetectedDots, used_prior: bool) -> Fix | NoFix:
        """Fit the full model, starting from a pose of the search."""
        settings = self._settings
        # Standard deviation of the uniform distribution: tolerance over sqrt(3).
        tolerances = settings.scale_tolerance, settings.tilt_tolerance, settings.tilt_tolerance
        priors = np.array(tolerances) / math.sqrt(3.0)
        rays = self._mount.camera_points_from_floor(points.points)
        mounted = MountedRays(rays, self._mount.rotation, np.array(self._mount.xyz))
        initial = _upright_state(start, self._mount)
        state, covariance, matches = refine_pose(self._floor.grid, mounted, points.sigmas, initial, priors)
        matched = matches >= 0
        match_rate = float(np.mean(matched))
        if match_rate < settings.match_rate_min or matched.sum() < 3:
            return NoFix(NoFixReason.UNCERTAIN, f'match rate {match_rate:.0%} after the fit', dots)
        map_points = np.where(matched[:, None], self._floor.grid.points[matches], np.nan)
        x, y, yaw, scale, roll, pitch = (float(value) for value in state)
        pose, chance_alignments = SE2(x, y, wrap_angle(yaw)), math.exp(max(start.log_chance, -700.0))
        matches_of_dots = matched[: len(dots)], map_points[: len(dots)]
        found = pose, covariance[:3, :3], dots, *matches_of_dots, match_rate, scale, (roll, pitch)
        return Fix(*found, chance_alignments, used_prior)

    def _explain_failure(
        self, view: ViewDots, search: SearchState, dots: DetectedDots, used_prior: bool, effort: float
    ) -> NoFix:
        """Return the reason for no pose."""
        best = search.best
        found = f'{best.matched:.0f} of {len(dots)} dots match at best'
        if math.isfinite(best.log_chance):
            found += f', expected chance alignments {math.exp(min(best.log_chance, 700.0)):.1g}'
        if used_prior:
            return NoFix(NoFixReason.OUTSIDE_AREA, found, dots)
        if best.log_chance < 0.0:
            return NoFix(NoFixReason.UNCERTAIN, found, dots)
        mirrored, cells = mirror_view(view), int(effort * _MIRROR_CELLS)
        mirror_search = self._new_search(view, float(len(self._floor.grid.points)))
        if search_constellations(self._floor.grid, self._floor.index, mirrored, mirror_search, cells):
            return NoFix(NoFixReason.MIRRORED, f'{len(dots)} dots', dots)
        return NoFix(NoFixReason.NO_MATCH, found, dots)

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


def _upright_state(pose: ScoredPose, mount: CameraMount) -> Floats:
    """Return the state without tilt, shape (6,), that is equivalent to a pose of the search."""
    a, scale = pose.a, abs(pose.a) - 1.0
    # A higher camera scales the view about the point below the camera, but the similarity scales it about the base.
    base = pose.b + scale * a / abs(a) * complex(mount.xyz[0], mount.xyz[1])
    return np.array([base.real, base.imag, math.atan2(a.imag, a.real), scale, 0.0, 0.0])


def _describe_pose(pose: ScoredPose) -> str:
    return f'{pose.matched:.0f} dots match at ({pose.b.real:.2f}, {pose.b.imag:.2f}) m'
