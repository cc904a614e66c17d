import numpy as np
import pytest
from floor_views import CAMERA, MOUNT

from floor_localizer.core.pose_fit import MountedRays, project_to_map
from floor_localizer.core.survey.adjustment.bundle_adjustment import SuspensionPriors, bundle_adjust
from floor_localizer.core.survey.adjustment.observations import Observations, project_rays_to_map
from shirube_core.geometry import SE2

POSITION = np.array(MOUNT.xyz)
PRIORS = SuspensionPriors(POSITION, 0.01, 0.01)


def scene(noise: float, sway: float = 0.0, images: int = 12, dots: int = 300):
    """A row of images over random dots; directions from the inverse of the model, by Newton's method."""
    rng = np.random.default_rng(5)
    points = rng.uniform((-0.06, -0.06), (0.03 * images + 0.06, 0.06), (dots, 2))
    states = np.zeros((images, 6))
    states[:, 0] = 0.03 * np.arange(images)
    states[1:, 3:] = rng.normal(0.0, sway, (images - 1, 3))
    image, dot = np.nonzero(np.abs(points[None] - states[:, None, :2]).max(axis=2) < 0.045)
    directions = np.column_stack([np.zeros((len(dot), 2)), np.full(len(dot), -1.0)])
    wanted = points[dot] + rng.normal(0.0, noise, (len(dot), 2))
    for _ in range(30):
        off = wanted - project_rays_to_map(directions, POSITION, states[image])
        directions[:, :2] += off / POSITION[2]
    sigmas = np.full(len(dot), max(noise, 1e-6))
    return Observations(image, dot, directions, sigmas, np.full(len(dot), 0.002)), states, points


def adjust(observations, start):
    return bundle_adjust(observations, start, np.full((300, 2), np.nan), PRIORS)


def test_the_model_is_that_of_the_pose_fit():
    rng = np.random.default_rng(1)
    seen, states = CAMERA.rays_from_pixels(rng.uniform(0.0, 234.0, (20, 2))), rng.normal(0.0, 0.05, (20, 6))
    mounted = MountedRays(seen, MOUNT.rotation.copy(), POSITION)
    expected = [project_to_map(mounted, k, states[k]) for k in range(20)]
    found = project_rays_to_map(seen @ MOUNT.rotation.T, POSITION, states)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_without_noise_the_truth_comes_back_from_a_rough_start():
    observations, states, points = scene(0.0)
    start = states.copy()
    start[1:, :3] += np.random.default_rng(2).normal(0.0, 0.0005, (len(states) - 1, 3))
    found = adjust(observations, start)
    seen = np.unique(observations.dot)
    np.testing.assert_allclose(found.states, states, atol=1e-6)
    np.testing.assert_allclose(found.dots[seen], points[seen], atol=1e-6)


def test_noise_does_not_shrink_the_map():
    observations, states, _ = scene(0.0003)
    found = adjust(observations, states)
    # Without the term for it, this is -0.5 % and more.
    assert abs(found.states[:, 3].mean()) < 0.0005


def test_false_observations_hardly_matter():
    observations, states, _ = scene(0.00002)
    rng = np.random.default_rng(3)
    wrong = rng.choice(len(observations.dot), len(observations.dot) // 30, replace=False)
    observations.directions[wrong, :2] += 0.01
    found = adjust(observations, states)
    assert np.abs(found.states[:, :2] - states[:, :2]).max() < 0.0004


def test_fixed_dots_stay_and_hold_the_images():
    observations, states, points = scene(0.00001, sway=0.005)
    moved = states.copy()
    moved[:, :2] += (0.0007, -0.0004)
    found = bundle_adjust(observations, moved, points, PRIORS)
    np.testing.assert_array_equal(found.dots, points)
    np.testing.assert_allclose(found.states[:, :2], states[:, :2], atol=0.0001)


@pytest.mark.parametrize('shift', [SE2(3.0, -1.0, 0.0), SE2(0.0, 0.0, 2.0)])
def test_the_result_moves_along_with_the_start(shift):
    observations, states, _ = scene(0.00003)
    seen = np.unique(observations.dot)
    first = adjust(observations, states).dots[seen]
    moved = states.copy()
    moved[:, :2] = shift.transform(states[:, :2])
    moved[:, 2] += shift.yaw
    found = adjust(observations, moved).dots[seen]
    np.testing.assert_allclose(found, shift.transform(first), atol=2e-6)
