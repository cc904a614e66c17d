"""Synthetic localization results, without images."""

from dataclasses import replace

import numpy as np
from taught_wall import HERE, RIG, taught_place

from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_localizer import LandmarkFix, NoLandmarkFix
from stereo_landmark.core.pair.pair_stream import LocatedPair
from stereo_landmark.core.place.place_locator import PlaceFix
from stereo_landmark.core.procedure.coarse_pose import predict_pixels
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.target_search import NoDetectionReason, NoTargetDetection, TargetDetection
from stereo_landmark.core.stereo import StereoPoints

IMAGE = np.full((240, 376), 100, np.uint8)
COVARIANCE = np.diag([1e-6, 4e-6, 9e-6, 1e-4])
MISSING = NoTargetDetection('door', NoDetectionReason.AMBIGUOUS, 'log-likelihood ratios 5 and 5')


def detection(state=HERE):
    """Return the detection of the meters from a robot state."""
    place = taught_place()
    view = StereoView(None, None, RIG)
    (pixels,) = predict_pixels(np.array([state[:4]]), place.coordinates.positions, view)
    points = StereoPoints(place.coordinates.names, pixels, np.tile(0.01 * np.eye(4), (len(pixels), 1, 1)))
    names = tuple(f'meters/meter {i + 1}' for i in range(4))
    return TargetDetection('meters', np.array(state[:4]), points, names, 50.0)


def with_fix(in_map=True, stamp_ns=10_000_000_000):
    """Return a result with a fix."""
    place = taught_place() if in_map else replace(taught_place(), T_map_place=None)
    pose = SE2(HERE[0], HERE[1], HERE[3])
    names = place.coordinates.names[:3]
    fix = PlaceFix(pose, 0.02, (0.0, 0.0), COVARIANCE, names, np.zeros((3, 4)))
    return LocatedPair(stamp_ns, IMAGE, LandmarkFix(place, fix, (detection(), MISSING)), (0.0, 0.0), RIG)


def without_fix(stamp_ns=10_000_000_000):
    """Return a result without a fix."""
    result = NoLandmarkFix('no similar shapes in view', 'place wall: meters', (MISSING,))
    return LocatedPair(stamp_ns, IMAGE, result, (0.0, 0.0), RIG)
