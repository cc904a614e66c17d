import numpy as np
from floor_views import CAMERA, MOUNT

from floor_localizer.core.survey.adjustment.observations import count_expected_views, merge_observations
from floor_localizer.core.survey.survey_image import view_outline
from shirube_core.geometry import SE2


def test_observations_of_one_dot_are_merged_and_others_are_not():
    rng = np.random.default_rng(1)
    dots = np.stack(np.meshgrid(np.arange(10), np.arange(10)), axis=-1).reshape(-1, 2) * 0.005
    image, dot = np.repeat(np.arange(6), len(dots)), np.tile(np.arange(len(dots)), 6)
    labels = merge_observations(dots[dot] + rng.normal(0.0, 0.0001, (len(dot), 2)), image, 0.0006)
    assert labels.max() + 1 == len(dots)
    assert all(len(set(labels[dot == k])) == 1 for k in range(len(dots)))


def test_two_dots_of_one_image_stay_two():
    near = np.array([[0.0, 0.0], [0.0005, 0.0]])
    points = np.vstack([near, near + 0.00005, near - 0.00005])
    labels = merge_observations(points, np.repeat([0, 1, 2], 2), 0.0006)
    np.testing.assert_array_equal(labels[::2], labels[0])
    np.testing.assert_array_equal(labels[1::2], labels[1])
    assert labels[0] != labels[1]


def test_the_images_that_should_see_a_dot_are_those_whose_picture_holds_it():
    rng, outline = np.random.default_rng(2), view_outline(CAMERA, MOUNT)
    states = np.zeros((20, 6))
    states[:, :3] = rng.uniform((-0.05, -0.05, -3.0), (0.05, 0.05, 3.0), (20, 3))
    dots = rng.uniform(-0.1, 0.1, (200, 2))
    expected = np.zeros(200, dtype=int)
    for state in states:
        base = SE2(*state[:3]).inverse().transform(dots)
        pixels = CAMERA.pixels_from_points(MOUNT.camera_points_from_floor(base))
        expected += ((pixels > 0.0) & (pixels < 234.0)).all(axis=1)
    np.testing.assert_array_equal(count_expected_views(dots, states, outline, 0.0), expected)
