"""``shirube try landmarks``: which shapes of a wall are worth teaching, from how far, and how exactly they give the pose.

The pairs are taught and located as `teach --drive` does it: the middle pair is taught, the others are located there.
"""

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from shirube_cli.project import CommandError
from shirube_cli.suitability.pictures import Image, grey, parse, read_film
from shirube_core.geometry import CameraMount, PinholeCamera
from stereo_landmark.core.features.image_features import detect_features, match_features
from stereo_landmark.core.landmark_localizer import LandmarkFix
from stereo_landmark.core.pair.rectification_check import PairFault, check_pair
from stereo_landmark.core.place.place_locator import NoPlaceFix
from stereo_landmark.core.primitives.primitive import ImageProcessing, difference
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.settings import LandmarkSettings, PlaceSettings
from stereo_landmark.core.stereo import StereoImages, StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.drive_proposal import DriveProposal, propose_place
from stereo_landmark.core.teaching.hints import POSITION_SIGMA_MAX, SIMILAR_MAX, report_target
from stereo_landmark.core.teaching.primitive_selection import NearestSelection, TargetSelection, select_primitives
from stereo_landmark.core.teaching.teacher import Teacher
from stereo_landmark.node_settings import NodeSettings

_INLIERS_MIN, _INLIER_DISTANCE = 30, 1.5  # of an epipolar geometry [-, px]
_FOUND_MIN = 0.7  # of the other pairs


def rectify(left: Image, right: Image, rig: StereoRig) -> StereoImages:
    """Return a rectified pair; one that was taken from two places by hand is rectified by its features.

    Raises:
        CommandError: the photographs have too little in common, or left and right are swapped.
    """
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
    mount = CameraMount(NodeSettings.camera_xyz, NodeSettings.camera_rpy)
    rig = StereoRig(camera, camera, options.baseline, mount)
    pairs = [rectify(left, right, rig) for left, right in zip(greys[::2], greys[1::2], strict=True)]
    try:
        proposal = propose_place('tried', len(pairs), pairs.__getitem__, rig, LandmarkSettings())
    except StereoLandmarkError as error:
        print(f'This wall does not suit: {error}')
        return 1
    others = [each for number, each in enumerate(proposal.results) if number != proposal.taught]
    located = sum(isinstance(each, LandmarkFix) for each in others)
    is_exact = _print_proposal(proposal, pairs[proposal.taught], rig)
    print(f'other pairs located: {located} of {len(others)}')
    if not is_exact or located < _FOUND_MIN * len(others):
        print('This wall does not suit from here: go nearer, use a wider baseline, or put up signs.')
        return 1
    print(f'This wall {"suits" if others else "possibly suits"}.')
    if not others:
        print('One pair does not show whether the shapes are found again: add pairs from 0.3 m beside, and turned.')
    return int(not others)


def _print_proposal(proposal: DriveProposal, pair: StereoImages, rig: StereoRig) -> bool:
    """Print the shapes of a proposed place and what they are worth; return whether they give an exact pose."""
    processing, (target,) = ImageProcessing(), proposal.place.targets
    scenes = [detect_scene(image, processing) for image in (pair.left, pair.right)]
    teacher = Teacher(StereoView(*scenes, rig), processing)
    wanted = [NearestSelection(each.kind, tuple(each.shape.centre), name=each.name) for each in target.primitives]
    shapes = select_primitives([*wanted], scenes[0])
    print('shape               at u, v px  distance m  alike in view')
    for taught in target.primitives:
        detected = scenes[0].kinds[taught.kind].primitives
        alike = sum(difference(each, shapes[taught.name], processing.tolerances) <= 1.0 for each in detected) - 1
        u, v = taught.shape.centre
        far = float(np.linalg.norm(taught.position))
        print(f'{taught.name:<18}  {u:4.0f}, {v:4.0f}  {far:10.2f}  {alike:13d}{"  repeats" if alike > SIMILAR_MAX else ""}')
    report = report_target(TargetSelection(target.name, shapes), shapes, teacher, PlaceSettings())
    print(*(f'{hint.severity.value}: {hint.text}' for hint in report.hints), sep='\n')
    if isinstance(report.fix, NoPlaceFix):
        return False
    sigma, far = report.fix.position_sigma, float(np.linalg.norm(target.positions, axis=1).mean())
    print(f'expected error: {1e3 * sigma:.1f} mm, {math.degrees(report.fix.yaw_sigma):.2f} degrees at {far:.1f} m; '
          f'{1e3 * POSITION_SIGMA_MAX:.0f} mm at about {far * math.sqrt(POSITION_SIGMA_MAX / sigma):.1f} m')  # fmt: skip
    return sigma <= POSITION_SIGMA_MAX


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
