"""Refinement of a similarity to the full model, with the right matches."""

from __future__ import annotations

import math

import numpy as np
import pytest
from floor_views import CAMERA, MOUNT, pose_over, see
from scipy.stats import chi2

from floor_localizer.core.pose_fit import MountedRays, refine_pose
from shirube_core.geometry import SE2

PRIORS = np.array([0.03, 0.02, 0.02])


def refined(indexed_floor, view, start, sigma=8e-5):
    rays = CAMERA.rays_from_pixels(view.dots.pixels)
    mounted = MountedRays(rays, MOUNT.rotation, np.array(MOUNT.xyz))
    return refine_pose(indexed_floor.grid, mounted, np.full(len(rays), sigma), np.array(start), PRIORS)


@pytest.mark.parametrize('seed', range(5))
def test_a_near_start_leads_to_the_truth(floor, indexed_floor, seed):
    rng = np.random.default_rng(seed)
    pose, tilt, scale = pose_over(rng), rng.uniform(-0.01, 0.01, 2), rng.uniform(-0.02, 0.02)
    view = see(floor, pose, rng, tilt=tilt, scale=scale, spurious=5)
    found = refined(indexed_floor, view, [pose.x + 1e-4, pose.y - 1e-4, pose.yaw + 0.001, scale, *tilt * 0.7])
    assert pose.distance_to(SE2(*found.state[:3])) < 1e-4
    np.testing.assert_allclose(found.state[3:], [scale, *tilt], atol=0.01)


def test_dots_are_matched_with_those_that_they_are(floor, indexed_floor):
    rng = np.random.default_rng(9)
    pose = pose_over(rng)
    view = see(floor, pose, rng, spurious=6)
    found = refined(indexed_floor, view, [pose.x, pose.y, pose.yaw, 0.0, 0.0, 0.0])
    real = (view.sources >= 0) & (found.matches >= 0)
    assert np.mean(real[view.sources >= 0]) > 0.97
    np.testing.assert_allclose(
        indexed_floor.grid.points[found.matches[real]], floor.points[view.sources[real]], atol=1e-6
    )
    assert np.sum(found.matches[view.sources < 0] >= 0) <= 1


@pytest.mark.parametrize('noise', [0.01, 0.2])
@pytest.mark.parametrize('axis', range(6))
def test_tilt_far_beyond_the_noise_keeps_the_dots(floor, indexed_floor, noise, axis):
    rng = np.random.default_rng(axis)
    pose, tilt = pose_over(rng), math.radians(2.0) * np.array([math.cos(axis), math.sin(axis)])
    view = see(floor, pose, rng, tilt=tilt, noise=noise, spurious=8)
    start = similarity_of(floor, view)
    found = refined(indexed_floor, view, start, sigma=noise * MOUNT.xyz[2] / CAMERA.fx)
    real = view.sources >= 0
    assert np.mean(found.matches[real] >= 0) > 0.95
    error = found.state - [pose.x, pose.y, pose.yaw, 0.0, *tilt]
    assert error @ np.linalg.solve(found.covariance, error) < chi2.ppf(0.9999, 6)


def test_sigmas_that_are_half_the_noise_keep_most_dots(floor, indexed_floor):
    kept = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        view = see(floor, pose_over(rng), rng, noise=0.2)
        sigma = 0.1 * MOUNT.xyz[2] / CAMERA.fx
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
    rays = MountedRays(CAMERA.rays_from_pixels(pixels), MOUNT.rotation, np.array(MOUNT.xyz))
    found = refine_pose(indexed_floor.grid, rays, np.full(len(few), 5e-5), np.array(start), PRIORS)
    error = (found.state - start)[:3]
    assert error @ np.linalg.solve(found.covariance[:3, :3], error) < chi2.ppf(0.9999, 3)


def similarity_of(floor, view):
    """The best state without tilt for a view's own dots: the result of a search for similarities."""
    real = view.sources >= 0
    base = MOUNT.floor_points_from_rays(CAMERA.rays_from_pixels(view.dots.pixels[real]))
    z, m = base @ (1.0, 1j), floor.points[view.sources[real]] @ (1.0, 1j)
    turn, shift = np.linalg.lstsq(np.column_stack([z, np.ones(len(z))]), m, rcond=None)[0]
    scale = abs(turn) - 1.0
    base_place = shift + scale * turn / abs(turn) * complex(*MOUNT.xyz[:2])
    return [base_place.real, base_place.imag, np.angle(turn), scale, 0.0, 0.0]


def test_far_from_everything_nothing_is_matched(floor, indexed_floor):
    rng = np.random.default_rng(9)
    view = see(floor, pose_over(rng), rng)
    start = [50.0, 50.0, 0.0, 0.0, 0.0, 0.0]
    found = refined(indexed_floor, view, start)
    assert np.all(found.matches == -1)
    np.testing.assert_array_equal(found.state, start)
