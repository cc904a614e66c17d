"""Displacements from one target at 2, 3 and 5 m against the truth: `./shirube bench landmark_accuracy`.

Prints the markdown of the section "Accuracy" of stereo_landmark.md: errors with the bound of Cramér and Rao, the
stated covariance, and ORB, SIFT and one AprilTag in the same views.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from itertools import islice

import numpy as np
from _landmark_bound import CAMERAS, PoseBound
from _landmark_score import OURS, Result, error_of, print_results
from _landmark_views import RIG, LandmarkView, LandmarkWall, repeat_poses, teach_pose
from _product_rig import product_rig
from _stereo_peers import FeaturePipeline
from _tag_peer import TagPeer, is_available
from _timed_answers import use_one_core
from numpy.typing import NDArray
from tqdm import tqdm

from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_fix import LandmarkFix, NoLandmarkFix
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.place.place_locator import PlaceFix, PlaceLocator
from stereo_landmark.core.place.reprojection import reproject
from stereo_landmark.core.primitives.primitive import ImageProcessing, Primitive, PrimitiveKind
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import LandmarkSettings, PlaceSettings
from stereo_landmark.core.stereo import StereoPoints
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

DISTANCES = (2.0, 3.0, 5.0)
EXACT = PlaceSettings(pixel_sigma=0.0, tilt_sigma=0.0)
"""The rendered rig is exactly calibrated and level."""
CHOSEN_WITHIN = 1.0
"""A measured corner is that of the field when it is so near [px]."""
FIELDS_MIN = 4
FIT_SIGMA = 0.015
"""Noise of points for the fit alone, along each axis of each image [px]."""
PLANAR = np.ix_([0, 1, 3], [0, 1, 3])


def taught_panel(wall: LandmarkWall, view: LandmarkView) -> TaughtPlace | None:
    """Return the place with those fields as its target of which both images show the corners.

    The engineer sees that; a program looks whether they are where they truly are. None for less than four fields.
    """
    processing = ImageProcessing()
    left, right = (detect_scene(image, processing) for image in view.panel)
    stereo = StereoView(left, right, CAMERAS)
    teacher = Teacher(stereo, processing, EXACT.pixel_sigma)
    quadrilaterals = left.kinds[PrimitiveKind.QUADRILATERAL].primitives
    chosen = {}
    for number, corners in enumerate(field_pixels(wall, view.T_map_base)):
        here, there = corners[:, :2], corners[:, 2:]
        ways = [_farthest(each, here) for each in quadrilaterals]
        nearest = quadrilaterals[int(np.argmin(ways))]
        try:
            pair = teacher.measure(nearest)
        except StereoLandmarkError:
            continue
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


def fields_of(place: TaughtPlace) -> list[int]:
    """Return the numbers of the fields that were taught."""
    return [int(primitive.name.split()[1]) for primitive in place.targets[0].primitives]


def _farthest(found: Primitive, corners: NDArray[np.float64]) -> float:
    """Return how far a corner of a quadrilateral is from where it is to be, whichever corner is the first."""
    if not isinstance(found, Quadrilateral):
        return math.inf
    return min(float(np.abs(np.roll(found.corners, k, axis=0) - corners).max()) for k in range(4))


class Methods:
    """All methods, taught with one view.

    Args:
        place: the panel.
        view: when it was taught.
        pipelines: feature pipelines.
        tag: the tag's detector, None where OpenCV has none.
    """

    def __init__(
        self, place: TaughtPlace, view: LandmarkView, pipelines: list[FeaturePipeline], tag: TagPeer | None
    ) -> None:
        self._localizer = LandmarkLocalizer([place], LandmarkSettings(place=EXACT))
        self._view, self._tag = view, tag
        self._taught = [(pipeline, pipeline.teach(view.panel)) for pipeline in pipelines]

    def fix(self, view: LandmarkView) -> PlaceFix | NoLandmarkFix:
        """Return shirube's displacement, or why there is none."""
        answer = self._localizer.locate(*view.panel)
        return answer.displacement if isinstance(answer, LandmarkFix) else answer

    def peers(self, view: LandmarkView) -> Iterator[tuple[str, SE2 | None]]:
        """Yield the name and the answer of each peer."""
        for pipeline, taught in self._taught:
            yield f'{pipeline.name} + PnP', pipeline.locate(taught, pipeline.features(view.panel[0]))
        if self._tag is not None:
            yield 'AprilTag, one image', self._tag.locate_from_left(self._view.tag, view.tag)
            yield 'AprilTag, both images', self._tag.locate_from_both(self._view.tag, view.tag)


def run(distance: float, wanted: int, repeats: int, seed: int, bar: tqdm[None], *, grain: bool) -> Result:
    """Return the errors at one distance, of so many lessons with so many repeats each."""
    result = Result()
    tag = TagPeer() if is_available() else None
    pipelines = [FeaturePipeline(name, product_rig(RIG)) for name in ('ORB', 'SIFT')]
    for number in range(wanted):
        rng = np.random.default_rng((seed, round(distance), number))
        cells = np.zeros((1, 1), np.bool_) if tag is None else tag.cells()
        wall = LandmarkWall(seed + number, cells, grain=grain)
        lesson = wall.view(teach_pose(distance, rng), rng)
        place = taught_panel(wall, lesson)
        if place is None:
            result.untaught += 1
            bar.update(repeats)
            continue
        result.points.append(len(place.coordinates))
        methods = Methods(place, lesson, pipelines, tag)
        bound = PoseBound(wall, lesson, fields_of(place))
        for pose in islice(repeat_poses(lesson.T_map_base, rng), repeats):
            view, truth = wall.view(pose, rng), lesson.T_map_base.inverse() @ pose
            fix = methods.fix(view)
            result.add(OURS, fix.T_place_base if isinstance(fix, PlaceFix) else None, truth)
            for name, found in methods.peers(view):
                result.add(name, found, truth)
            if isinstance(fix, PlaceFix):
                result.compare(fix, truth, bound.covariance(view, truth), fit_alone(place, fix, truth, rng))
            else:
                result.misses.append(f'{distance:g} m, lesson {number}: {fix.reason} ({fix.detail})')
            bar.update()
    return result


def fit_alone(
    place: TaughtPlace, fix: PlaceFix, truth: SE2, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return error and stated covariance of the fit of points that have exactly the stated noise.

    Args:
        place: taught points, taken for the truth, and their covariances.
        fix: names the points; each is seen with the noise that such points have in the taught images.
        truth: the displacement.
        rng: random generator of the noise.
    """
    true = place.coordinates.select(fix.names)
    state = np.array([truth.x, truth.y, 0.0, truth.yaw, 0.0, 0.0])
    noise = np.tile(FIT_SIGMA**2 * np.eye(4), (len(true), 1, 1))
    pairs = []
    for at in (np.zeros(6), state):
        pixels = reproject(at, true.positions, CAMERAS).pixels
        pairs.append(StereoPoints(true.names, pixels + FIT_SIGMA * rng.normal(size=pixels.shape), noise))
    locator = PlaceLocator(CAMERAS, EXACT)
    answer = locator.locate(pairs[1], locator.spatial_points(pairs[0]))
    if not isinstance(answer, PlaceFix):
        return None
    return error_of(answer.T_place_base, truth), answer.covariance[PLANAR]


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description='Displacements from one target against the truth.')
    parser.add_argument(
        '--lessons', type=int, default=8, help='times that the target is taught, at each distance'
    )
    parser.add_argument('--repeats', type=int, default=8, help='views of each lesson')
    parser.add_argument(
        '--distances', type=float, nargs='+', default=DISTANCES, choices=DISTANCES, help='which of them [m]'
    )
    parser.add_argument('--seed', type=int, default=1, help='of everything')
    parser.add_argument(
        '--plain', action='store_true', help='a panel whose paint has no grain, as the bound supposes'
    )
    arguments = parser.parse_args()
    use_one_core()
    results = {}
    with tqdm(total=len(arguments.distances) * arguments.lessons * arguments.repeats, leave=False) as bar:
        for distance in arguments.distances:
            results[distance] = run(
                distance, arguments.lessons, arguments.repeats, arguments.seed, bar, grain=not arguments.plain
            )
    print_results(results)
    if not is_available():
        print('OpenCV has no AprilTags here: pip install opencv-python-headless>=4.7', file=sys.stderr)
    return 0


if __name__ == '__main__':
    sys.exit(main())
