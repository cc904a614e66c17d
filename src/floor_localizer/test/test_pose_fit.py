"""Ground truth recovered from exact dots, comparison to scipy, and covariance compared to Monte Carlo."""

import math

import numpy as np
import pytest
from floor_views import CAMERA, pose_over, see
from floor_views import MOUNT as VIEW_MOUNT
from scipy.optimize import least_squares
from scipy.stats import chi2

from floor_localizer.core.pose_fit import MountedRays, fit_pose, project_to_map, refine_pose
from shirube_core.geometry import SE2, CameraMount, matrix_from_rpy

MOUNT = CameraMount(xyz=(0.11, -0.04, 0.13), rpy=(math.pi + 0.05, -0.08, 0.4))
STATE = np.array([3.2, -1.1, 2.3, 0.03, 0.02, -0.015])
WIDE = np.full(3, 1e3)
SIGMA = 5e-5


def targets_of(rays, state, mount=MOUNT):
    """Intersections of rays with the floor, from rotation matrices and plane geometry."""
    body = matrix_from_rpy((state[4], state[5], 0.0))
    centre = body @ mount.xyz + (0.0, 0.0, state[3] * mount.xyz[2])
    directions = rays @ (body @ mount.rotation).T
    base = centre - directions * (centre[2] / directions[:, 2])[:, None]
    return SE2(*state[:3]).transform(base[:, :2])


@pytest.fixture
def rays():
    pixels = np.random.default_rng(0).uniform(-0.34, 0.34, (40, 2))
    return np.column_stack([pixels, np.ones(40)])


@pytest.fixture
def mounted(rays):
    return MountedRays(rays, MOUNT.rotation, np.array(MOUNT.xyz))


def fitted(mounted, targets, *, sigmas=None, matched=None, priors=WIDE, start=None):
    sigmas = np.full(len(targets), SIGMA) if sigmas is None else sigmas
    matched = np.ones(len(targets), dtype=np.bool_) if matched is None else matched
    state = np.add(STATE, (0.002, -0.002, 0.02, -0.03, -0.02, 0.015)) if start is None else start.copy()
    return state, fit_pose(mounted, targets, sigmas, matched, priors, state)


@pytest.mark.parametrize('length', [1.0, 7.3])
def test_model_is_that_of_rays_of_any_length_and_planes_and_of_the_mount(rays, length):
    stretched = MountedRays(rays * length, MOUNT.rotation, np.array(MOUNT.xyz))
    level = np.array([0.4, 0.7, -2.0, 0.0, 0.0, 0.0])
    expected = SE2(*level[:3]).transform(MOUNT.floor_points_from_rays(rays))
    for state, targets in ((STATE, targets_of(rays, STATE)), (level, expected)):
        found = [project_to_map(stretched, k, state) for k in range(len(rays))]
        np.testing.assert_allclose(found, targets, atol=1e-12)


@pytest.mark.parametrize('matched', [np.ones(40, np.bool_), np.arange(40) % 2 == 0])
def test_exact_dots_give_back_pose_height_and_tilt_and_unmatched_ones_do_not_matter(mounted, rays, matched):
    targets = targets_of(rays, STATE)
    targets[~matched] = 99.0
    state, _ = fitted(mounted, targets, matched=matched)
    np.testing.assert_allclose(state, STATE, atol=1e-7)


def noisy(rays, seed):
    rng = np.random.default_rng(seed)
    return targets_of(rays, STATE) + rng.normal(0.0, SIGMA, (len(rays), 2))


def test_a_second_solver_finds_the_same(mounted, rays):
    targets, priors = noisy(rays, 1), np.array([0.03, 0.02, 0.02])
    sigmas = np.random.default_rng(2).uniform(0.5, 2.0, len(rays)) * SIGMA

    def residuals(state):
        misses = (targets_of(rays, state) - targets) / sigmas[:, None]
        return np.concatenate([misses.ravel(), state[3:] / priors])

    second = least_squares(residuals, STATE, x_scale='jac', xtol=1e-14, ftol=1e-14, gtol=1e-14)
    state, covariance = fitted(mounted, targets, sigmas=sigmas, priors=priors)
    np.testing.assert_allclose(state[:2], second.x[:2], atol=1e-7)
    np.testing.assert_allclose(state[2:], second.x[2:], atol=1e-6)
    expected = np.linalg.inv(second.jac.T @ second.jac)
    np.testing.assert_allclose(covariance, expected, atol=2e-3 * np.max(np.abs(expected)))


@pytest.mark.newest_set_only
def test_covariance_is_the_scatter_of_many_fits(mounted, rays):
    fits = [fitted(mounted, noisy(rays, seed)) for seed in range(600)]
    states, covariance = np.array([state for state, _ in fits]), fits[0][1]
    scatter = np.cov(states.T)
    # The standard deviation of a variance from 600 samples is 6 %.
    np.testing.assert_allclose(np.diag(scatter), np.diag(covariance), rtol=0.25)
    errors = states - STATE
    mahalanobis = np.einsum('ni,ij,nj->n', errors, np.linalg.inv(covariance), errors)
    assert np.mean(mahalanobis) == pytest.approx(6.0, rel=0.15)


def test_four_times_as_much_noise_is_sixteen_times_the_covariance(mounted, rays):
    targets = targets_of(rays, STATE)
    _, once = fitted(mounted, targets)
    _, fourfold = fitted(mounted, targets, sigmas=np.full(len(rays), 4.0 * SIGMA))
    np.testing.assert_allclose(fourfold, 16.0 * once, rtol=1e-3)


def test_narrow_priors_hold_height_and_tilt(mounted, rays):
    state, covariance = fitted(mounted, noisy(rays, 3), priors=np.full(3, 1e-9), start=STATE)
    np.testing.assert_allclose(state[3:], 0.0, atol=1e-6)
    assert np.all(np.diag(covariance)[3:] <= 1.001e-18)


def test_moving_the_map_moves_the_pose_along(mounted, rays):
    move = SE2(-3.0, 7.0, 1.1)
    targets = noisy(rays, 4)
    state, _ = fitted(mounted, targets)
    expected = move @ SE2(*state[:3])
    start = STATE.copy()
    start[:3] = expected.x + 0.002, expected.y, expected.yaw + 0.01
    moved, _ = fitted(mounted, move.transform(targets), start=start)
    np.testing.assert_allclose(moved[:2], (expected.x, expected.y), atol=1e-7)
    assert math.remainder(moved[2] - expected.yaw, math.tau) == pytest.approx(0.0, abs=1e-7)
    np.testing.assert_allclose(moved[3:], state[3:], atol=1e-6)


PRIORS = np.array([0.03, 0.02, 0.02])


def refined(indexed_floor, view, start, sigma=8e-5):
    rays = CAMERA.rays_from_pixels(view.dots.pixels)
    mounted = MountedRays(rays, VIEW_MOUNT.rotation, np.array(VIEW_MOUNT.xyz))
    return refine_pose(indexed_floor.grid, mounted, np.full(len(rays), sigma), np.array(start), PRIORS)


@pytest.mark.parametrize('seed', range(5))
def test_a_near_start_leads_to_the_truth_and_the_right_dots(floor, indexed_floor, seed):
    rng = np.random.default_rng(seed)
    pose, tilt, scale = pose_over(rng), rng.uniform(-0.01, 0.01, 2), rng.uniform(-0.02, 0.02)
    view = see(floor, pose, rng, tilt=tilt, scale=scale, spurious=5)
    found = refined(indexed_floor, view, [pose.x + 1e-4, pose.y - 1e-4, pose.yaw + 0.001, scale, *tilt * 0.7])
    assert pose.distance_to(SE2(*found.state[:3])) < 1e-4
    np.testing.assert_allclose(found.state[3:], [scale, *tilt], atol=0.01)
    real = (view.sources >= 0) & (found.matches >= 0)
    assert np.mean(real[view.sources >= 0]) > 0.97
    expected = floor.points[view.sources[real]]
    np.testing.assert_allclose(indexed_floor.grid.points[found.matches[real]], expected, atol=1e-6)
    assert np.sum(found.matches[view.sources < 0] >= 0) <= 1


@pytest.mark.parametrize('noise', [0.01, 0.2])
@pytest.mark.parametrize('axis', range(6))
def test_tilt_far_beyond_the_noise_keeps_the_dots(floor, indexed_floor, noise, axis):
    rng = np.random.default_rng(axis)
    pose, tilt = pose_over(rng), math.radians(2.0) * np.array([math.cos(axis), math.sin(axis)])
    view = see(floor, pose, rng, tilt=tilt, noise=noise, spurious=8)
    start = similarity_of(floor, view)
    found = refined(indexed_floor, view, start, sigma=noise * VIEW_MOUNT.xyz[2] / CAMERA.fx)
    real = view.sources >= 0
    assert np.mean(found.matches[real] >= 0) > 0.95
    error = found.state - [pose.x, pose.y, pose.yaw, 0.0, *tilt]
    assert error @ np.linalg.solve(found.covariance, error) < chi2.ppf(0.9999, 6)


def test_sigmas_that_are_half_the_noise_keep_most_dots(floor, indexed_floor):
    kept = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        view = see(floor, pose_over(rng), rng, noise=0.2)
        sigma = 0.1 * VIEW_MOUNT.xyz[2] / CAMERA.fx
        kept.append(np.mean(refined(indexed_floor, view, similarity_of(floor, view), sigma).matches >= 0))
    assert np.mean(kept) > 0.85


@pytest.mark.parametrize('seed', range(8))
def test_a_false_dot_does_not_bend_a_view_of_few(floor, indexed_floor, seed):
    """An outlier of half a millimetre, as from two merged chips, must not be fitted by a false tilt."""
    rng = np.random.default_rng(seed)
    pose = pose_over(rng)
    view = see(floor, pose, rng)
    few = np.argsort(np.hypot(*(view.dots.pixels - 117.0).T))[::6]
    start = [pose.x, pose.y, pose.yaw, 0.0, 0.0, 0.0]
    pixels = view.dots.pixels[few]
    pixels[-1] += 1.5
    rays = MountedRays(CAMERA.rays_from_pixels(pixels), VIEW_MOUNT.rotation, np.array(VIEW_MOUNT.xyz))
    found = refine_pose(indexed_floor.grid, rays, np.full(len(few), 5e-5), np.array(start), PRIORS)
    error = (found.state - start)[:3]
    assert error @ np.linalg.solve(found.covariance[:3, :3], error) < chi2.ppf(0.9999, 3)


def similarity_of(floor, view):
    """The best state without tilt for a view's own dots: the result of a search for similarities."""
    real = view.sources >= 0
    base = VIEW_MOUNT.floor_points_from_rays(CAMERA.rays_from_pixels(view.dots.pixels[real]))
    z, m = base @ (1.0, 1j), floor.points[view.sources[real]] @ (1.0, 1j)
    turn, shift = np.linalg.lstsq(np.column_stack([z, np.ones(len(z))]), m, rcond=None)[0]
    scale = abs(turn) - 1.0
    base_place = shift + scale * turn / abs(turn) * complex(*VIEW_MOUNT.xyz[:2])
    return [base_place.real, base_place.imag, np.angle(turn), scale, 0.0, 0.0]


def test_far_from_everything_nothing_is_matched(floor, indexed_floor):
    rng = np.random.default_rng(9)
    view = see(floor, pose_over(rng), rng)
    start = [50.0, 50.0, 0.0, 0.0, 0.0, 0.0]
    found = refined(indexed_floor, view, start)
    assert np.all(found.matches == -1)
    np.testing.assert_array_equal(found.state, start)
