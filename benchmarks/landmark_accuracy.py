"""Displacements from one target at 2, 3 and 5 m against the truth, beside ORB, SIFT and one AprilTag.

A panel of 0.8 m with six fields is taught from one pair and looked for from poses up to 0.5 m and 15° away; the tag
replaces it in the same views.
"""

import math
from collections import defaultdict
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import islice

import cv2
import numpy as np
from _figures import mean, rate, rms
from _harness import Option, Run, progress, run_benchmark, use_one_core
from _landmark_views import SIDE, LandmarkView, LandmarkWall, repeat_poses, teach_pose
from _pose_scores import PoseScore, pose_cells, score_found, whitened_errors
from _stereo_peers import FeaturePipeline, planar_displacement
from _stereo_scenes import CAMERAS, Pair
from numpy.typing import NDArray

from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.core.place.joint_fit import reproject
from stereo_landmark.core.place.place_locator import PlaceFix, PlaceLocator
from stereo_landmark.core.primitives.primitive import ImageProcessing, Primitive, PrimitiveKind
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import LandmarkSettings, PlaceSettings
from stereo_landmark.core.stereo import StereoPoints
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

EXACT = PlaceSettings(pixel_sigma=0.0, tilt_sigma=0.0)  # the rendered rig is exactly calibrated and level
CHOSEN_WITHIN = 1.0  # A measured corner is that of the field when it is so near [px]
FIELDS_MIN = 4
PLANAR = np.ix_([0, 1, 3], [0, 1, 3])
OURS = 'shirube'
ANY = math.inf, math.inf  # all poses count as right here
TAG, CELLS = 7, 8
CORNER_SIGMA = 0.1  # stated of a corner [px]; it is the same for all, so that the fit does not depend on it
NAMES = tuple(f'corner {i}' for i in range(4))
SQUARE = 0.5 * SIDE * np.array([[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, -1.0, 0.0]])


@dataclass
class Result:
    """Answers at one distance.

    Attributes:
        scores: answers of each method.
        used: number of points that each fix was made of.
        points: number of points of each lesson.
    """

    scores: dict[str, list[PoseScore]] = field(default_factory=lambda: defaultdict(list))
    used: list[int] = field(default_factory=list)
    points: list[int] = field(default_factory=list)


def taught_panel(wall: LandmarkWall, view: LandmarkView) -> TaughtPlace | None:
    """Return the place with those fields as its target of which both images show the corners.

    The engineer sees that; a program looks whether they are where they truly are. None for less than four fields.
    """
    processing = ImageProcessing()
    left, right = (detect_scene(image, processing) for image in view.panel)
    teacher = Teacher(StereoView(left, right, CAMERAS), processing, EXACT.pixel_sigma)
    quadrilaterals = left.kinds[PrimitiveKind.QUADRILATERAL].primitives
    chosen = {}
    for number, corners in enumerate(field_pixels(wall, view.T_map_base)):
        here, there = corners[:, :2], corners[:, 2:]
        nearest = quadrilaterals[int(np.argmin([_farthest(each, here) for each in quadrilaterals]))]
        with suppress(StereoLandmarkError):
            pair = teacher.measure(nearest)
            if max(_farthest(pair[0], here), _farthest(pair[1], there)) < CHOSEN_WITHIN:
                chosen[f'field {number}'] = nearest
    if len(chosen) < FIELDS_MIN:
        return None
    return teacher.teach('wall', [TargetSelection('panel', chosen)])


def field_pixels(wall: LandmarkWall, T_map_base: SE2) -> NDArray[np.float64]:
    """Return where the corners of the fields are seen, shape (FIELDS, 4, 4): u, v left and u, v right [px]."""
    corners = wall.field_corners().reshape(-1, 3)
    base = np.column_stack([T_map_base.inverse().transform(corners[:, :2]), corners[:, 2]])
    return reproject(np.zeros(6), base, CAMERAS).pixels.reshape(-1, 4, 4)


def _farthest(found: Primitive, corners: NDArray[np.float64]) -> float:
    """Return how far a corner of a quadrilateral is from where it is to be, whichever corner is the first."""
    if not isinstance(found, Quadrilateral):
        return math.inf
    return min(float(np.abs(np.roll(found.corners, k, axis=0) - corners).max()) for k in range(4))


class TagPeer:
    """One AprilTag (36h11) of known size: OpenCV's detector with sub-pixel corners, from one image or from both."""

    def __init__(self) -> None:
        self._dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.ArucoDetector(self._dictionary, parameters)
        self._locator = PlaceLocator(CAMERAS, replace(EXACT, gate_sigmas=20.0))

    def cells(self) -> NDArray[np.bool_]:
        """Return the tag with its black border, shape (CELLS, CELLS), true for white."""
        return np.asarray(cv2.aruco.generateImageMarker(self._dictionary, TAG, CELLS) > 127, dtype=np.bool_)

    def corners(self, image: NDArray[np.uint8]) -> NDArray[np.float64] | None:
        """Return the tag's corners, shape (4, 2) [px]; None if it is not found."""
        corners, ids, _ = self._detector.detectMarkers(image)
        if ids is None or TAG not in np.ravel(ids):
            return None
        found = corners[np.ravel(ids).tolist().index(TAG)]
        return np.asarray(found, dtype=np.float64).reshape(4, 2)

    def locate_from_left(self, then: Pair, now: Pair) -> SE2 | None:
        """Return the displacement between the left images of two pairs, in six degrees of freedom each."""
        poses = []
        for image in (then[0], now[0]):
            corners = self.corners(image)
            if corners is None:
                return None
            matrix = CAMERAS.left.matrix
            is_found, *motion = cv2.solvePnP(SQUARE, corners, matrix, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
            if not is_found:
                return None
            turn, shift = cv2.solvePnPRefineLM(SQUARE, corners, matrix, None, *motion)
            poses.append((cv2.Rodrigues(turn)[0], shift.ravel()))
        (R_then, shift_then), (R_now, shift_now) = poses
        R_now_then = R_now @ R_then.T
        return planar_displacement(R_now_then, shift_now - R_now_then @ shift_then, CAMERAS)

    def locate_from_both(self, then: Pair, now: Pair) -> SE2 | None:
        """Return the displacement that explains the corners in all four images best, on a level floor."""
        seen = []
        for left, right in (then, now):
            here, there = self.corners(left), self.corners(right)
            if here is None or there is None:
                return None
            noise = np.tile(CORNER_SIGMA**2 * np.eye(4), (4, 1, 1))
            seen.append(StereoPoints(NAMES, np.hstack([here, there]), noise))
        fix = self._locator.locate(seen[1], self._locator.spatial_points(seen[0]))
        return fix.T_place_base if isinstance(fix, PlaceFix) else None


def measure(run: Run, distance: float, wanted: int, repeats: int) -> Result:
    """Return the errors at one distance, of so many lessons with so many repeats each."""
    result, tag = Result(), TagPeer()
    pipelines = [FeaturePipeline(name, CAMERAS) for name in ('ORB', 'SIFT')]
    for number in progress(range(wanted), f'lessons at {distance:g} m'):
        rng = np.random.default_rng((run.seed, round(distance), number))
        wall = LandmarkWall(run.seed + number, tag.cells())
        lesson = wall.view(teach_pose(distance, rng), rng)
        place = taught_panel(wall, lesson)
        if place is None:
            run.note(f'{distance:g} m, lesson {number}: fewer than four fields are measured')
            continue
        result.points.append(len(place.coordinates))
        localizer = LandmarkLocalizer([place], LandmarkSettings(place=EXACT))
        taught = [(each.name, each, each.teach(lesson.panel)) for each in pipelines]
        for pose in islice(repeat_poses(lesson.T_map_base, rng), repeats):
            view, truth = wall.view(pose, rng), lesson.T_map_base.inverse() @ pose
            fix = localizer.locate(*view.panel)
            if isinstance(fix, LandmarkFix):
                found, covariance = fix.displacement, fix.displacement.covariance[PLANAR]
                score = score_found(found.T_place_base, truth, ANY, covariance=covariance)
                result.used.append(len(found.names))
            else:
                score = PoseScore('none')
                run.note(f'No pose: {distance:g} m, lesson {number}: {fix.reason} ({fix.detail})')
            result.scores[OURS].append(score)
            answers = {
                f'{name} + PnP': each.locate(known, each.features(view.panel[0])) for name, each, known in taught
            }
            answers['AprilTag, one image'] = tag.locate_from_left(lesson.tag, view.tag)
            answers['AprilTag, both images'] = tag.locate_from_both(lesson.tag, view.tag)
            for name, answer in answers.items():
                result.scores[name].append(score_found(answer, truth, ANY))
    return result


def main(run: Run, lessons: int, repeats: int, distances: tuple[float, ...]) -> None:
    """Measure the errors at all distances."""
    use_one_core()
    heads = 'distance | method | found | position mm: median / 95 % / max | heading °: the same'
    errors = run.table('Errors', heads)
    consistency = run.table('Stated covariance', 'distance | points taught | used | error / stated')
    for distance in distances:
        result, name = measure(run, distance, lessons, repeats), f'{distance:g} m'
        for method, scores in result.scores.items():
            found = rate(sum(score.verdict == 'right' for score in scores), len(scores))
            errors.add(name, method, found, *pose_cells(scores, '.2f', '.4f', shown=(50, 95, 100))[1:])
        if result.used:
            points = (mean(each, '.1f', better='higher') for each in (result.points, result.used))
            consistency.add(name, *points, rms(whitened_errors(result.scores[OURS]), '.2f', better='one'))


if __name__ == '__main__':
    run_benchmark(
        main,
        lessons=Option(24, 1, 'times that the target is taught, at each distance'),
        repeats=Option(4, 3, 'views of each lesson'),
        distances=Option((2.0, 3.0, 5.0), (2.0, 3.0, 5.0), '[m]'),
    )
