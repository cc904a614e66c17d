"""The rig finds the side of the top camera, and rejects inconsistent images."""

import numpy as np
import pytest
from l_rig import BASELINE, CAMERA, picture, projection, true_depth

from reward_planner.core.depth.depth_settings import DepthSettings
from reward_planner.core.depth.trinocular_depth import TrinocularRig
from reward_planner.core.reward_planner_error import RewardPlannerError


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


def test_a_frame_without_texture_decides_nothing():
    cameras = rig(BASELINE)
    blank = np.full(picture().shape, 128, dtype=np.uint8)
    assert np.isnan(cameras.compute(blank, blank, blank).depth).mean() > 0.9
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
    images[covered] = np.zeros_like(images[covered])
    assert points_of(rig(-BASELINE), *images) < 10


@pytest.mark.parametrize('mean', [3, 128])
@pytest.mark.parametrize('noise', [1, 2, 5])
def test_noise_is_no_depth(mean, noise):
    rng = np.random.default_rng(mean + noise)
    images = [rng.normal(mean, noise, picture().shape).clip(0, 255).astype(np.uint8) for _ in range(3)]
    assert points_of(rig(-BASELINE), *images) < 0.002 * picture().size


def test_swapped_images_give_no_depth():
    assert points_of(rig(-BASELINE), picture(x=BASELINE), picture(), picture(y=-BASELINE)) < 10


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


def test_a_frame_without_texture_does_not_mirror_a_confirmed_rig():
    cameras = rig(-BASELINE)
    cameras.compute(picture(), picture(x=BASELINE), picture(y=-BASELINE))
    covered = np.zeros_like(picture())
    points_of(cameras, picture(), covered, picture(y=BASELINE))
    assert not cameras.is_mirrored
