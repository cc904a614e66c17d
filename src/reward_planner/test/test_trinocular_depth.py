"""Depth of two pairs, and of a rig whose top camera may be on either side."""

import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from l_rig import BASELINE, CAMERA, picture, projection, true_depth

from reward_planner.core.depth.stereo_pair import PairMatcher, StereoPair, pair_from_projections
from reward_planner.core.depth.trinocular_depth import (
    BOTH,
    FIRST,
    INCONSISTENT,
    NO_DEPTH,
    TrinocularDepth,
    TrinocularRig,
    depth_from_disparity,
)
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import DepthSettings

TSUKUBA = Path(os.environ.get('SHIRUBE_DATA', 'not given')) / 'planner' / 'tsukuba'
RIGHT = pair_from_projections(projection(), projection(x=BASELINE))
TOP = pair_from_projections(projection(), projection(y=-BASELINE))


def of_rig(fusion):
    settings = DepthSettings(disparities=48, fusion=fusion)
    return TrinocularDepth(RIGHT, TOP, settings).compute(picture(), picture(x=BASELINE), picture(y=-BASELINE))


def scores(depth, truth, focal_baseline):
    """Coverage, and the fraction of matched pixels with an error of more than a pixel."""
    matched = np.isfinite(depth)
    error = np.abs(focal_baseline / depth - focal_baseline / truth)[matched]
    return matched.mean(), (error > 1.0).mean()


def test_agreement_is_right_more_often_and_union_has_fewer_gaps_than_two_cameras():
    two = depth_from_disparity(
        PairMatcher(RIGHT, DepthSettings(disparities=48)).match(picture(), picture(BASELINE)), RIGHT
    )
    covered, bad = scores(two, true_depth(), RIGHT.focal_baseline)
    covered_by_both, bad_of_both = scores(of_rig('agreement').depth, true_depth(), RIGHT.focal_baseline)
    covered_by_union, bad_of_union = scores(of_rig('union').depth, true_depth(), RIGHT.focal_baseline)
    assert bad_of_both < 0.6 * bad
    assert covered_by_union > covered + 0.05
    assert covered_by_union > covered_by_both
    assert bad_of_union < bad + 0.005


def test_the_depth_of_both_pairs_is_the_least_squares_one():
    long = pair_from_projections(projection(), projection(y=-0.15))
    settings = DepthSettings(disparities=48)
    seen = TrinocularDepth(RIGHT, long, settings).compute(picture(), picture(x=BASELINE), picture(y=-0.15))
    first = PairMatcher(RIGHT, settings).match(picture(), picture(x=BASELINE))
    second = PairMatcher(long, settings).match(picture(), picture(y=-0.15))
    rows, columns = np.nonzero(seen.source == BOTH)
    for row, column in zip(rows[::997], columns[::997]):
        design = np.array([[RIGHT.focal_baseline], [long.focal_baseline]])
        measured = np.array([first[row, column], second[row, column]])
        inverse = np.linalg.lstsq(design, measured, rcond=None)[0][0]
        assert seen.depth[row, column] == pytest.approx(1.0 / inverse, rel=1e-5)
    both = seen.source == BOTH
    assert both.mean() > 0.5
    assert np.median(np.abs(seen.depth / true_depth() - 1.0)[both]) < 0.01


def test_the_source_says_where_a_depth_is_from():
    union, agreement = of_rig('union'), of_rig('agreement')
    assert (np.isnan(union.depth) == np.isin(union.source, (NO_DEPTH, INCONSISTENT))).all()
    assert set(np.unique(agreement.source)) == {NO_DEPTH, BOTH, INCONSISTENT}
    assert ((agreement.source == BOTH) == (union.source == BOTH)).all()
    first = PairMatcher(RIGHT, DepthSettings(disparities=48)).match(picture(), picture(BASELINE))
    alone = union.source == FIRST
    assert union.depth[alone] == pytest.approx(depth_from_disparity(first, RIGHT)[alone])


@pytest.mark.skipif(not TSUKUBA.is_dir(), reason='SHIRUBE_DATA names no planner/tsukuba/')
def test_a_third_camera_halves_the_bad_pixels_of_tsukuba():
    views = {k: cv2.imread(str(TSUKUBA / f'c{k}.ppm'), cv2.IMREAD_GRAYSCALE) for k in (2, 3, 4)}
    grey = cv2.imread(str(TSUKUBA / 'gt.pgm'), cv2.IMREAD_GRAYSCALE)
    right, left = StereoPair(0, 0.1, 160.0, 0.0), StereoPair(0, -0.1, 160.0, 0.0)
    settings = DepthSettings(disparities=16)
    truth = np.where(grey > 0, right.focal_baseline * 16.0 / np.maximum(grey, 1), np.nan)
    known = grey > 0
    two = depth_from_disparity(PairMatcher(right, settings).match(views[3], views[4]), right)
    three = TrinocularDepth(right, left, settings).compute(views[3], views[4], views[2]).depth
    _, bad_of_two = scores(two[known], truth[known], right.focal_baseline)
    covered, bad_of_three = scores(three[known], truth[known], right.focal_baseline)
    assert bad_of_three < 0.65 * bad_of_two
    assert covered > 0.95


def rig(calibrated_y, matcher='sgbm'):
    """Return a rig whose calibration has the top camera at ``calibrated_y`` along y [m]."""
    projections = np.array([projection(), projection(x=BASELINE), projection(y=calibrated_y)])
    return TrinocularRig(projections, DepthSettings(matcher=matcher, disparities=48))


@pytest.mark.parametrize('matcher', ['sgbm', 'bm'])
@pytest.mark.parametrize('calibrated_y', [-BASELINE, BASELINE])
@pytest.mark.parametrize('place', [-BASELINE, BASELINE])
def test_the_depth_is_true_whichever_sign_the_baseline_has(matcher, calibrated_y, place):
    cameras = rig(calibrated_y, matcher)
    seen = cameras.compute(picture(), picture(x=BASELINE), picture(y=place))
    assert cameras.is_mirrored == (calibrated_y != place)
    assert seen.inconsistent_fraction < 0.05
    known = ~np.isnan(seen.depth)
    assert known.mean() > 0.7
    wrong = np.abs(1.0 / seen.depth - 1.0 / true_depth()) * CAMERA.fx * BASELINE > 1.0
    assert wrong[known].mean() < 0.06


def test_a_frame_without_texture_decides_nothing_and_does_not_mirror_a_confirmed_rig():
    cameras, blank = rig(BASELINE), np.full(picture().shape, 128, dtype=np.uint8)
    assert np.isnan(cameras.compute(blank, blank, blank).depth).mean() > 0.9
    assert not cameras.is_mirrored
    cameras = rig(-BASELINE)
    cameras.compute(picture(), picture(x=BASELINE), picture(y=-BASELINE))
    points_of(cameras, picture(), np.zeros_like(blank), picture(y=BASELINE))
    assert not cameras.is_mirrored


def test_a_top_camera_that_sees_something_else_is_refused():
    with pytest.raises(RewardPlannerError, match='are inconsistent'):
        rig(-BASELINE).compute(picture(), picture(x=BASELINE), turned())


def turned():
    """Image of a top camera that looks elsewhere."""
    return np.ascontiguousarray(picture(y=-BASELINE)[:, ::-1])


def points_of(cameras, *images):
    """Number of pixels with a depth; 0 if the images are rejected."""
    try:
        return np.isfinite(cameras.compute(*images).depth).sum()
    except RewardPlannerError:
        return 0


@pytest.mark.parametrize('covered', [0, 1, 2])
def test_depths_of_one_pair_are_rejected_while_the_other_sees_nothing(covered):
    images = [picture(), picture(x=BASELINE), picture(y=-BASELINE)]
    assert points_of(rig(-BASELINE), images[1], images[0], images[2]) < 10  # swapped
    images[covered] = np.zeros_like(images[covered])
    assert points_of(rig(-BASELINE), *images) < 10


@pytest.mark.parametrize('mean', [3, 128])
@pytest.mark.parametrize('noise', [1, 2, 5])
def test_noise_is_no_depth(mean, noise):
    rng = np.random.default_rng(mean + noise)
    images = [rng.normal(mean, noise, picture().shape).clip(0, 255).astype(np.uint8) for _ in range(3)]
    assert points_of(rig(-BASELINE), *images) < 0.002 * picture().size


def test_after_an_inconsistent_frame_frames_are_rejected_until_a_consistent_one():
    cameras = rig(-BASELINE)
    blank = np.full(picture().shape, 128, dtype=np.uint8)
    good = (picture(), picture(x=BASELINE), picture(y=-BASELINE))
    for images in ((picture(), picture(x=BASELINE), turned()), (blank, blank, blank)):
        with pytest.raises(RewardPlannerError, match='are inconsistent'):
            cameras.compute(*images)
    assert points_of(cameras, *good) > 0.7 * blank.size
    cameras.compute(blank, blank, blank)
    assert points_of(cameras, *good) > 0.7 * blank.size
