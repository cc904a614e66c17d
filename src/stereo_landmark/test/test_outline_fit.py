import math

import numpy as np
import pytest
from seen_shapes import SIZE, mahalanobis

from scene_simulator.corridor_generator import CorridorDesign, corridor
from scene_simulator.drawn_shapes import coverage, photograph, polygon_intervals
from scene_simulator.stereo_rig import StereoRig, render_pair
from shirube_geometry import PlanarPose
from stereo_landmark.core.primitives.edge_response import response_table
from stereo_landmark.core.primitives.outline_fit import fit_outline
from stereo_landmark.core.procedure.detected_scene import ImageProcessing, detect_scene
from stereo_landmark.core.procedure.primitive import refined

CORNERS = np.array([[22.3, 18.6], [78.1, 24.9], [70.4, 69.7], [28.8, 62.2]])
ROWS, COLUMNS = np.mgrid[: SIZE[1], : SIZE[0]]


def fit(light, start=CORNERS, noise=2.0, seed=0):
    return fit_outline(photograph(light, noise, seed), start, 0.7, response_table())


def plate(corners=CORNERS, outside=180.0, inside=100.0, blur=0.7):
    return outside + (inside - outside) * coverage(polygon_intervals(corners), SIZE, blur)


def test_is_unbiased_and_knows_its_errors_also_in_uneven_light():
    errors, squares = [], []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        corners = CORNERS + rng.uniform(-1.0, 1.0, (4, 2))
        light = 1.0 + 0.03 * (COLUMNS - 50.0) / 50.0 - 0.02 * (ROWS - 45.0) / 45.0
        found = fit(plate(corners) * light, corners + rng.uniform(-0.3, 0.3, (4, 2)), seed=seed)
        assert found.found
        errors.append(found.corners - corners)
        squares.append(mahalanobis(errors[-1].ravel(), found.covariance))
    assert np.sqrt(np.mean(np.square(errors))) < 0.025
    assert np.abs(np.mean(errors, axis=0)).max() < 0.015
    assert 0.7 < math.sqrt(np.mean(squares)) < 1.25


def test_is_more_certain_the_less_noise_there_is():
    sigmas = [np.trace(fit(plate(), noise=noise).covariance) for noise in (1.0, 2.0, 4.0)]
    assert sigmas == sorted(sigmas)


def frame(width):
    middle = CORNERS.mean(axis=0)
    inner = middle + (CORNERS - middle) * (1.0 - width / 22.0)
    return plate() + 110.0 * coverage(polygon_intervals(inner), SIZE, 0.7)


def test_the_inside_of_a_frame_does_not_draw_it_away():
    found = fit(frame(4.0))
    assert found.found
    assert np.abs(found.corners - CORNERS).max() < 0.12


@pytest.mark.parametrize(
    'light',
    [
        np.full(SIZE[::-1], 120.0),
        np.where(COLUMNS < 50, 40.0, 1.0) + plate(),
        plate()
        + 80.0 * coverage(polygon_intervals([[40, 0.0], [60, 0.0], [60, 90.0], [40, 90.0]]), SIZE, 0.7),
    ],
    ids=['nothing', 'two walls', 'something before it'],
)
def test_what_the_model_does_not_explain_is_not_fitted(light):
    assert not fit(light).found


def test_stated_covariances_are_sane_wherever_it_is_tried():
    """Of all primitives of a corridor, which has frames, texts and edges beside edges."""
    left, _ = render_pair(
        corridor(CorridorDesign(seed=3)), StereoRig(), PlanarPose(-3.5, 0.1, 0.05), np.random.default_rng(0)
    )
    for detected in detect_scene(left, ImageProcessing()).kinds.values():
        for primitive in detected.primitives:
            again = refined(primitive, left)
            if again is not None:
                spread = np.linalg.eigvalsh(again.covariance)
                assert np.isfinite(spread).all()
                assert 0.0 < spread[0] <= spread[-1] < 50.0
