"""``shirube try landmarks``: which shapes of a wall are worth teaching, how far they are, and how exact the pose is.

The pairs are taught and located as `teach --drive` does it: the middle pair is taught, the others are located there.
"""

import argparse
import math
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from shirube_cli.project import CommandError
from shirube_cli.suitability.pictures import Image, grey, parse, read_film
from shirube_core.geometry import CameraMount, PinholeCamera
from stereo_landmark.core.features.taught_features import detect_features, match_features
from stereo_landmark.core.landmark_localizer import LandmarkFix, NoLandmarkFix
from stereo_landmark.core.pair.rectification_check import PairFault, check_pair
from stereo_landmark.core.place.place_locator import PlaceFix
from stereo_landmark.core.primitives.primitive import ImageProcessing, Primitive, difference, primitive_kind
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.settings import LandmarkSettings, PlaceSettings
from stereo_landmark.core.stereo import StereoImages, StereoRig
from stereo_landmark.core.teaching.drive_proposal import CHOSEN_MIN, TARGET, list_candidates, localize_pairs
from stereo_landmark.core.teaching.hints import POSITION_SIGMA_MAX, SIMILAR_MAX, find_skewed_shapes, report_target
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher
from stereo_landmark.node_settings import NodeSettings

_INLIERS_MIN, _INLIER_DISTANCE = 30, 1.5  # of an epipolar geometry [-, px]
_FOUND_MIN = 0.7  # of the other pairs
_SETTINGS = LandmarkSettings(place=PlaceSettings(tilt_sigma=0.1))  # cameras in the hand


def rectify(left: Image, right: Image, rig: StereoRig) -> StereoImages:
    """Return a rectified pair, by its features if it was taken by hand; raise a CommandError if they are too few."""
    fault = check_pair(left, right, rig).fault
    if fault is PairFault.NOT_RECTIFIED:
        here, there = detect_features(left), detect_features(right)
        pairs, matrix = match_features(here, there), rig.left.matrix
        points = here.pixels[pairs[:, 0]], there.pixels[pairs[:, 1]]
        if len(pairs) < _INLIERS_MIN:
            raise CommandError('the photographs have too little in common; take both of one wall, a hand apart')
        essential, _ = cv2.findEssentialMat(*points, matrix, cv2.RANSAC, 0.999, _INLIER_DISTANCE)
        _, R, t, _ = cv2.recoverPose(essential[:3], *points, matrix)
        size, none = (rig.left.width, rig.left.height), np.zeros(5)
        turns = cv2.stereoRectify(matrix, none, matrix, none, size, R, t)[:2]
        maps = (cv2.initUndistortRectifyMap(matrix, none, turn, matrix, size, cv2.CV_32FC1) for turn in turns)
        left, right = (
            np.asarray(cv2.remap(each, *both, cv2.INTER_LINEAR), np.uint8)
            for each, both in zip((left, right), maps, strict=True)
        )
        fault = check_pair(left, right, rig).fault
    if fault is not None:
        raise CommandError(fault.value)
    return StereoImages(left, right)


def try_landmarks(arguments: Sequence[str]) -> int:
    """Print what is worth teaching; return 0 if the places of all pairs give a pose, or else 1."""
    options = parse(_parser(), arguments, 'stereo_landmark')
    if len(options.photos) % 2:
        raise CommandError('the number of photographs is odd; give LEFT RIGHT, then those of other places in pairs')
    greys = [grey(read_film(path, 1).pictures[0]) for path in options.photos]
    if len({each.shape for each in greys}) > 1:
        raise CommandError('the photographs have different sizes; take all with one camera')
    height, width = greys[0].shape
    focal = 0.5 * width / math.tan(0.5 * math.radians(options.fov))
    camera = PinholeCamera(width, height, focal, focal, 0.5 * (width - 1), 0.5 * (height - 1))
    mount = CameraMount((0.0, 0.0, 0.0), NodeSettings.camera_rpy)
    rig = StereoRig(camera, camera, options.baseline, mount)
    pairs = [rectify(left, right, rig) for left, right in zip(greys[::2], greys[1::2], strict=True)]
    taught = len(pairs) // 2
    processing, pair = ImageProcessing(), pairs[taught]
    left, right = (detect_scene(image, processing) for image in (pair.left, pair.right))
    teacher = Teacher(StereoView(left, right, rig), processing)
    shapes = _choose_shapes(teacher)
    if len(shapes) < CHOSEN_MIN:
        print(f'This wall does not suit: {len(shapes)} shapes are worth teaching, {CHOSEN_MIN} are needed; put up '
              'signs, go nearer, or use a wider baseline.')  # fmt: skip
        return 1
    selection = TargetSelection(TARGET, shapes)
    fix = report_target(selection, shapes, teacher, PlaceSettings()).fix
    if isinstance(fix, PlaceFix):
        print(f'expected error  {1e3 * fix.position_sigma:.1f} mm, {math.degrees(fix.yaw_sigma):.2f} degrees by the '
              'noise of the shapes; it grows with the square of the distance')  # fmt: skip
    results = localize_pairs(teacher.teach('tried', [selection]), len(pairs), pairs.__getitem__, _SETTINGS)
    for number, result in enumerate(results):
        text = 'taught'
        if number != taught and isinstance(result, LandmarkFix):
            pose = result.displacement.T_place_base
            text = f'{pose.x:.2f} m ahead, {pose.y:.2f} m left, turned by {math.degrees(pose.yaw):.1f} degrees'
        elif isinstance(result, NoLandmarkFix):
            text = f'not located: {result.reason}'
        print(f'pair {number + 1}  {text}')
    others = len(pairs) - 1
    located = sum(isinstance(each, LandmarkFix) for each in results[:taught] + results[taught + 1 :])
    is_exact = isinstance(fix, PlaceFix) and fix.position_sigma <= POSITION_SIGMA_MAX
    if not is_exact or located < _FOUND_MIN * others:
        print('This wall does not suit from here: keep the cameras level, go nearer, or put up signs.')
        return 1
    print(f'This wall {"suits" if others else "possibly suits"}.')
    if not others:
        print('One pair does not show whether it is found again: add pairs from 0.3 m beside it, and turned.')
    return int(not others)


def _choose_shapes(teacher: Teacher) -> dict[str, Primitive]:
    """Print the shapes that can be measured, and return those that are worth teaching, the rarest first."""
    shapes, alike = list_candidates(teacher), Counter[str]()
    report = report_target(TargetSelection(TARGET, shapes), shapes, teacher, PlaceSettings())
    measured = {name: pair[0] for name, pair in report.measured.items() if not isinstance(pair, str)}
    skewed = dict(find_skewed_shapes(measured, report.coordinates))
    print('shape               at u, v px  distance m  alike  worth teaching')
    for name, shape in shapes.items():
        of_shape = np.array([each.startswith(f'{name}/') for each in report.coordinates.names])
        far = float(np.linalg.norm(report.coordinates.positions[of_shape], axis=1).mean())
        detected = teacher.view.left.kinds[primitive_kind(shape)].primitives
        alike[name] = sum(difference(each, shape, teacher.processing.tolerances) <= 1.0 for each in detected) - 1
        u, v = shape.centre
        why = 'no, it repeats' if alike[name] > SIMILAR_MAX else 'no, it is no rectangle' if name in skewed else 'yes'
        print(f'{name:<18}  {u:4.0f}, {v:4.0f}  {far:10.2f}  {alike[name]:5d}  {why}')
    names = sorted(shapes, key=alike.__getitem__)
    return {name: shapes[name] for name in names if alike[name] <= SIMILAR_MAX and name not in skewed}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='shirube try landmarks',
        description='Judge a wall by a stereo pair, or by two photographs of one camera that was moved sideways, with '
        'what is on it still. More pairs, from other places in front of it, make the answer sure.',
    )
    add = parser.add_argument
    add('photos', nargs='+', type=Path, metavar='LEFT RIGHT', help='photographs, in pairs')
    add('--baseline', type=float, required=True, metavar='M', help='distance between the two cameras [m]')
    add('--fov', type=float, required=True, metavar='DEG', help='horizontal field of view of the photographs')
    return parser
