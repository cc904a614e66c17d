import numpy as np
import pytest
from place_scenes import RIG, panel, random_state, teach, view
from scipy.optimize import least_squares

from stereo_landmark.core.place.noise_groups import noise_groups
from stereo_landmark.core.place.reprojection_fit import fit_reprojection
from stereo_landmark.core.place.reprojection_model import reproject
from stereo_landmark.core.place.settings import PlaceSettings
from stereo_landmark.core.place.stereo_points import SpatialPoints, StereoPoints, joined

EXACT = PlaceSettings(pixel_sigma=0.0, tilt_sigma=0.0)


def _sharing(names, pixels, rng, sigma=0.1):
    """Return four points whose sixteen coordinates are all correlated, and their covariance, shape (16, 16)."""
    factor = sigma * rng.normal(size=(16, 20))
    whole = factor @ factor.T / 20.0
    between = whole.reshape(4, 4, 4, 4).copy()
    own = np.arange(4)
    covariances = between[own, :, own].copy()
    between[own, :, own] = 0.0
    # Less than stated, so that no point is taken for a wrong one.
    noise = 0.5 * np.linalg.cholesky(whole) @ rng.normal(size=16)
    return StereoPoints(names, pixels + noise.reshape(4, 4), covariances, between), whole


def _two_groups(seed):
    rng = np.random.default_rng(seed)
    points, state = panel(count=9, seed=seed), random_state(rng)
    clean = reproject(state, points, RIG).pixels
    names = tuple(f'point {i}' for i in range(9))
    first, whole = _sharing(names[:4], clean[:4], rng)
    second, other = _sharing(names[4:8], clean[4:8], rng)
    alone = StereoPoints(names[8:], clean[8:], 0.01 * np.eye(4)[None])
    return points, state, joined([first, second, alone]), (whole, other, 0.01 * np.eye(4))


@pytest.mark.parametrize('seed', range(5))
def test_shared_noise_is_weighed_as_general_least_squares_do(seed):
    points, state, seen, wholes = _two_groups(seed)
    taught = SpatialPoints(seen.names, points, np.zeros((9, 3, 3)))
    roots = [np.linalg.inv(np.linalg.cholesky(whole)) for whole in wholes]

    def residuals(planar):
        off = seen.pixels - reproject(np.array([*planar, 0.0, 0.0]), points, RIG).pixels
        parts = (off[:4], off[4:8], off[8:])
        return np.concatenate([root @ part.ravel() for root, part in zip(roots, parts, strict=True)])

    fit = fit_reprojection(seen, taught, RIG, state, EXACT)
    assert (fit.distances < 3.0).all()
    best = least_squares(residuals, state[:4], xtol=1e-14, ftol=1e-14)
    assert fit.state[:4] == pytest.approx(best.x, abs=1e-7)
    assert fit.covariance[:4, :4] == pytest.approx(np.linalg.inv(best.jac.T @ best.jac), rel=1e-3, abs=1e-12)


def test_groups_are_found_again_among_some_of_the_points():
    points, state, seen, _ = _two_groups(1)
    kept = np.array([False, True, True, True, True, True, True, False, True])
    taught = SpatialPoints(seen.names, points, np.zeros((9, 3, 3)))
    some = seen.subset(kept)
    groups = noise_groups(
        some, taught.selected(some.names), reproject(state, points[kept], RIG).by_point, 0.0
    )
    assert sorted(row for group in groups for row in group.members.tolist()) == [[0, 1, 2], [3, 4, 5], [6]]


def test_points_without_shared_noise_are_alone():
    points = panel(count=5)
    rng = np.random.default_rng(1)
    seen, taught = view(points, np.zeros(6), 0.1, rng), teach(points, 0.1, rng)
    (group,) = noise_groups(seen, taught, reproject(np.zeros(6), points, RIG).by_point, 0.0)
    assert group.members.tolist() == [[i] for i in range(5)]
    assert group.taught[:, 0, :, 0] == pytest.approx(taught.covariances)


def test_taught_points_keep_their_covariances_and_share_the_noise_of_the_present_ones():
    points, state, seen, _ = _two_groups(3)
    spread = np.random.default_rng(3).normal(size=(9, 3, 3))
    taught = SpatialPoints(seen.names, points, 1e-4 * spread @ spread.swapaxes(1, 2))
    by_point = reproject(state, points, RIG).by_point
    for group in noise_groups(seen, taught, by_point, 0.05):
        size = group.members.shape[1]
        for members, whole in zip(group.members, group.taught, strict=True):
            own = np.arange(size)
            assert whole[own, :, own] == pytest.approx(taught.covariances[members])
        assert (np.linalg.eigvalsh(group.spreads(by_point)) > 0.0).all()
        assert np.abs(group.taught[:, 0, :, -1]).max() > 1e-6
