"""The rig finds out on which side the top camera is, and refuses pictures that do not belong together."""

import numpy as np
import pytest
from l_rig import BASELINE, CAMERA, picture, projection, true_depth

from reward_planner.core.depth.depth_error import DepthError
from reward_planner.core.depth.depth_settings import DepthSettings
from reward_planner.core.depth.trinocular_rig import TrinocularRig


def rig(told, matcher='sgbm'):
    """Return a rig whose calibration tells of a top camera at a height ``told`` along y [m]."""
    projections = np.array([projection(), projection(x=BASELINE), projection(y=told)])
    return TrinocularRig(projections, DepthSettings(matcher=matcher, disparities=48))


@pytest.mark.parametrize('matcher', ['sgbm', 'bm'])
@pytest.mark.parametrize('told', [-BASELINE, BASELINE])
@pytest.mark.parametrize('place', [-BASELINE, BASELINE])
def test_the_depth_is_true_whichever_sign_the_baseline_has(matcher, told, place):
    cameras = rig(told, matcher)
    seen = cameras.compute(picture(), picture(x=BASELINE), picture(y=place))
    assert cameras.is_mirrored == (told != place)
    assert seen.contradiction < 0.05
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
    turned = np.ascontiguousarray(picture(y=-BASELINE)[:, ::-1])
    with pytest.raises(DepthError, match='contradict each other'):
        rig(-BASELINE).compute(picture(), picture(x=BASELINE), turned)
