"""Calibration of rendered and of computed views, whose truth is known."""

import numpy as np
import pytest
from board_scene import BASELINE, BOARD, CAMERA, RIGHT, Renderer, in_image, poses, seen_from_right

from shirube_camera.core.calibration import (
    Board,
    BoardView,
    ShirubeCameraError,
    advice,
    calibrate_lens,
    calibrate_stereo,
    select_views,
)

SIZE = CAMERA.width, CAMERA.height
CORNERS = Board(BOARD).corners


def truth_of(camera):
    return np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion])


def computed_views(count, seed, sigma=0.1, camera=CAMERA):
    """Return views whose corners have independent errors, without rendering."""
    random = np.random.default_rng(seed)
    pixels = [in_image(camera, R, centre, CORNERS) for R, centre in poses(count, seed)]
    return [BoardView(np.arange(len(p)), p + random.normal(0.0, sigma, p.shape)) for p in pixels]


@pytest.fixture(scope='module')
def pairs():
    board, left, right = Board(BOARD), Renderer(CAMERA), Renderer(RIGHT)
    found = [(board.detect(left(*p)), board.detect(right(*seen_from_right(*p)))) for p in poses(12)]
    return [pair for pair in found if None not in pair]


def test_a_rendered_pair_gives_the_truth_within_its_standard_deviations(pairs):
    stereo, *lenses = calibrate_stereo(CORNERS, pairs, SIZE)
    for lens, camera in zip(lenses, (CAMERA, RIGHT)):
        assert (np.abs(lens.parameters - truth_of(camera)) < 4.0 * lens.sigmas).all()
        assert lens.sigmas[0] < 2e-3 * camera.fx
    assert abs(stereo.parameters[0] - BASELINE) < 4.0 * stereo.sigmas[0] < 4e-4
    assert np.sqrt((np.concatenate(stereo.residuals) ** 2).mean()) < 0.15
    left, right = stereo.projections
    assert right[0, 3] == pytest.approx(-left[0, 0] * stereo.parameters[0], rel=1e-6)


def test_cameras_in_the_wrong_order_are_refused(pairs):
    with pytest.raises(ShirubeCameraError, match='give the left one first'):
        calibrate_stereo(CORNERS, [(right, left) for left, right in pairs], SIZE)


def test_the_standard_deviations_are_those_of_the_errors():
    lenses = [calibrate_lens(CORNERS, computed_views(10, seed), SIZE) for seed in range(10)]
    normalized = np.array([(lens.parameters - truth_of(CAMERA)) / lens.sigmas for lens in lenses])
    assert 0.5 < np.sqrt((normalized**2).mean()) < 1.3


def test_a_spoilt_view_is_rejected_and_does_no_harm():
    views = computed_views(14, 3)
    bent = views[5].pixels + 2.0 * np.sin(views[5].pixels / 30.0)
    lens = calibrate_lens(CORNERS, [*views[:5], BoardView(views[5].ids, bent), *views[6:]], SIZE)
    assert lens.used == [k for k in range(14) if k != 5]
    assert (np.abs(lens.parameters - truth_of(CAMERA)) < 4.0 * lens.sigmas).all()


def test_views_that_look_alike_are_used_once_and_weak_ones_are_named():
    views = computed_views(8, 1)
    assert select_views(CORNERS, [view for view in views for _ in range(4)], SIZE[0]) == [*range(0, 32, 4)]
    still = [BoardView(np.arange(54), in_image(CAMERA, np.eye(3), c, CORNERS)) for _, c in poses(12)]
    words = ' '.join(advice(calibrate_lens(CORNERS, still, SIZE), still))
    assert all(each in words for each in ('Turn the board sideways', 'up and down', 'focal length'))


def test_too_few_views_and_corners_that_fit_no_lens_are_refused():
    with pytest.raises(ShirubeCameraError, match='only 4 views can be used'):
        calibrate_lens(CORNERS, computed_views(4, 0), SIZE)
    with pytest.raises(ShirubeCameraError, match='do not fit'):
        calibrate_lens(CORNERS, computed_views(8, 0, sigma=8.0), SIZE)
