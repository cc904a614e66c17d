"""The paper's search of a target in a stereo pair (paper 3.4, fig. 6): the paper mode.

Each image is searched on its own by the procedure tree, in windows. The surroundings of the target are not used; a
combination that another one at a different pose equals, or misses by one primitive only, is ambiguous.
"""

import math
from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np

from stereo_landmark.core.arrays import Floats, GreyImage
from stereo_landmark.core.place.point_registration import closed_form, find_consensus_set
from stereo_landmark.core.procedure.coarse_pose import DETECTED_SIGMA, image_distances, is_in_view, predict_pixels
from stereo_landmark.core.procedure.pose_hypotheses import FALSE_POSITIVE_MIN
from stereo_landmark.core.procedure.procedure_tree import (
    Combination,
    Detection,
    ProcedureTree,
    SearchRegion,
    WindowDetector,
)
from stereo_landmark.core.procedure.stereo_matching import ROW_DIFFERENCE_MAX
from stereo_landmark.core.procedure.stereo_view import NamedPair, align_pair, refine_pair, stereo_points
from stereo_landmark.core.procedure.target_search import (
    DISTINCT_POSE_DISTANCE,
    NoDetectionReason,
    NoTargetDetection,
    TargetDetection,
    TargetResult,
    correct_circle_centres,
)
from stereo_landmark.core.procedure.taught_place import TaughtPlace, TaughtPrimitive, TaughtTarget
from stereo_landmark.core.settings import SearchSettings
from stereo_landmark.core.stereo import MEASUREMENT_SIZE, SpatialPoints, StereoPoints, TiltedCameras, is_measurable


class _Candidate(NamedTuple):
    """A combination of both images: its primitives, x, y, z [m] and yaw [rad], its score and the minimum score."""

    pairs: list[NamedPair]
    state: Floats
    score: float
    needed: float


class PaperSearch:
    """Searches the targets of one place as the paper does."""

    def __init__(self, place: TaughtPlace, settings: SearchSettings) -> None:
        self._place, self._settings = place, settings
        probability = settings.detection_probability
        self._found_score = math.log(probability / FALSE_POSITIVE_MIN + 1.0 - probability)
        self._missing_score = math.log(1.0 - probability)

    def search(
        self, target: TaughtTarget, images: tuple[GreyImage, GreyImage], tilt: tuple[float, float]
    ) -> TargetResult:
        """Search a target.

        Args:
            target: target of the place.
            images: rectified grey images of the left and the right camera, each of shape (h, w).
            tilt: roll and pitch of the base [rad].
        """
        cameras = TiltedCameras(self._place.rig, tilt)
        # 1. The windows of each image, with the image processing of the target (3.2, 3.3b).
        trees = [self._procedure_tree(target, side, image, cameras) for side, image in enumerate(images)]
        # 2. The paths of the procedure tree in the order of their weights (fig. 7), until one succeeds. The next one
        # is followed, too, as it may show rivals (not in the paper).
        candidates: list[_Candidate] = []
        has_succeeded = False
        for first in range(len(target.primitives)):
            left, right = (tree.search(first) for tree in trees)
            # 3. Combinations of both images, by the primitives found and their relations in space (fig. 8).
            candidates += self._candidates(target, left, right, cameras)
            if has_succeeded:
                break
            has_succeeded = any(each.score >= each.needed for each in candidates)
        if not candidates:
            detail = f'searched for {len(target.primitives)} primitives'
            return NoTargetDetection(target.name, NoDetectionReason.NO_CANDIDATE, detail)
        candidates.sort(key=lambda each: -each.score)
        best = candidates[0]
        # 4. A combination that could be due to chance, or is not the only one, is rejected (not in the paper).
        fault = self._check_best(target, candidates, cameras)
        if fault is not None:
            return fault
        # 5. Corresponding points in the grey images (3.3d).
        refined = ((name, refine_pair(one, other, images)) for name, one, other in best.pairs)
        measured = [(name, *pair) for name, pair in refined if pair is not None]
        points = correct_circle_centres(stereo_points(measured), target, best.state, cameras)
        return TargetDetection(target.name, best.state, points, tuple(name for name, *_ in measured), best.score)

    def _procedure_tree(
        self, target: TaughtTarget, side: int, image: GreyImage, cameras: TiltedCameras
    ) -> ProcedureTree:
        """Return the procedure tree of one image, the left (side 0) or the right one."""
        # Regions in which the primitives can be: where the robot sees them from the poses that are searched.
        distance, yaw = self._settings.distance_max, self._settings.yaw_max
        steps = product((0.0, -distance, distance), (0.0, -distance, distance), (0.0,), (0.0, -yaw, yaw))
        pixels = predict_pixels(np.array(list(steps)), target.positions, cameras)
        pixels = pixels[..., 2 * side : 2 * side + 2]
        low, high = np.nan_to_num(pixels, nan=-np.inf), np.nan_to_num(pixels, nan=np.inf)
        margin, size = self._settings.window, np.array(image.shape[::-1], dtype=np.float64)
        low = np.clip(low.min(axis=0) - margin, 0.0, size)
        high = np.clip(high.max(axis=0) + margin, 0.0, size)
        shapes = [each.shape for each in target.primitives]
        regions = [SearchRegion(*each) for each in zip(shapes, low, high, strict=True)]
        detector = WindowDetector(image, target.processing or self._place.processing, regions)
        return ProcedureTree(detector, shapes, pixels[0], self._settings)

    def _candidates(
        self, target: TaughtTarget, left: list[Combination], right: list[Combination], cameras: TiltedCameras
    ) -> Iterator[_Candidate]:
        """Yield the combinations of both images whose primitives are at a possible pose of the robot."""
        needed = max(1.0, self._settings.found_fraction_min * len(target.primitives))
        for here, there in product(left, right):
            both = [
                (target.primitives[k], here.found[k], there.found[k])
                for k in sorted(here.found.keys() & there.found.keys())
                if abs(here.found[k].centre.imag - there.found[k].centre.imag) <= ROW_DIFFERENCE_MAX
            ]
            candidate = self._locate(target, both, cameras) if len(both) >= needed else None
            if candidate is not None:
                yield candidate

    def _locate(
        self, target: TaughtTarget, both: list[tuple[TaughtPrimitive, Detection, Detection]], cameras: TiltedCameras
    ) -> _Candidate | None:
        """Return a candidate with its pose and score; None if the robot cannot be there."""
        pairs = [
            (f'{target.name}/{each.name}', *align_pair(each.shape, one.primitive, other.primitive))
            for each, one, other in both
        ]
        detected, taught = self._corresponding_points(both, pairs)
        if not is_measurable(detected, cameras.rig).all():
            return None
        found = cameras.spatial_points(detected)
        # Points at other distances than the taught ones do not count (3.4, end).
        kept = find_consensus_set(found, taught, 0.0).inliers
        displacement = closed_form(found.positions[kept], taught.positions[kept])
        if displacement is None:
            return None
        x, y, z, yaw = state = displacement.state
        if math.hypot(x, y) > self._settings.distance_max or abs(yaw) > self._settings.yaw_max:
            return None
        cos, sin = math.cos(yaw), math.sin(yaw)
        turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        errors = found.positions - (taught.positions - [x, y, z]) @ turn.T
        spread = found.covariances + turn @ taught.covariances @ turn.T
        squares = np.einsum('ni,nij,nj->n', errors, np.linalg.inv(spread), errors)
        # As in the likelihood of a hypothesis: primitives count for it, missing ones or those out of place against it.
        misfits = 0.5 * np.maximum(0.0, squares - 3.0)
        worst = misfits.max() if len(both) == 1 else misfits
        score = float(np.maximum(self._missing_score, self._found_score - worst).sum())
        pixels = predict_pixels(state[None], target.positions, cameras)
        in_view = is_in_view(pixels, cameras.rig) & is_in_view(pixels[..., [2, 3]], cameras.rig)
        visible = max(int(in_view.sum()), len(both))
        score += (visible - len(both)) * self._missing_score
        # Without surroundings, the target itself must be there for the most part.
        needed = self._settings.found_fraction_min * self._found_score * visible
        return _Candidate(pairs, state, score, max(needed, self._settings.log_likelihood_ratio_min))

    def _corresponding_points(
        self, both: list[tuple[TaughtPrimitive, Detection, Detection]], pairs: list[NamedPair]
    ) -> tuple[StereoPoints, SpatialPoints]:
        """Return the detected points and the taught ones: those of a single primitive, otherwise all centres."""
        if len(both) == 1:
            points = stereo_points(pairs)
            pixels, names = points.pixels, points.names
            taught = self._place.coordinates.select(names)
        else:
            # Nested outlines have nearly the same centre, but not the same corners.
            names = tuple(name for name, *_ in pairs)
            centres = np.array([[one.centre, other.centre] for _, one, other in both])
            pixels = np.stack([centres.real, centres.imag], axis=2).reshape(-1, MEASUREMENT_SIZE)
            positions = np.array([each.position for each, *_ in both])
            taught = SpatialPoints(names, positions, np.zeros((len(names), 3, 3)))
        noise = np.tile(DETECTED_SIGMA**2 * np.eye(MEASUREMENT_SIZE), (len(names), 1, 1))
        return StereoPoints(names, pixels, noise), taught

    def _check_best(
        self, target: TaughtTarget, candidates: list[_Candidate], cameras: TiltedCameras
    ) -> NoTargetDetection | None:
        """Return why the first of the candidates, the best ones first, is not accepted; None if it is."""
        best, needed = candidates[0].score, candidates[0].needed
        if best < needed:
            detail = f'log-likelihood ratio {best:.1f}, {needed:.1f} is needed'
            return NoTargetDetection(target.name, NoDetectionReason.NOT_SIGNIFICANT, detail)
        # The surroundings do not tell a hidden primitive from a target that is one further: a pose that lacks one more
        # primitive than the best one is a rival, too.
        states = np.array([each.state for each in candidates])
        is_distinct = image_distances(states, target.positions, cameras) > DISTINCT_POSE_DISTANCE
        rival = max(
            (each.score for each, is_other in zip(candidates, is_distinct, strict=True) if is_other), default=0.0
        )
        margin = self._settings.margin + self._found_score - self._missing_score
        if rival >= self._settings.log_likelihood_ratio_min and best - rival < margin:
            detail = f'log-likelihood ratios {best:.1f} and {rival:.1f}'
            return NoTargetDetection(target.name, NoDetectionReason.AMBIGUOUS, detail)
        return None
