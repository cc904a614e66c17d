import numpy as np
import pytest

from stereo_landmark.core.least_squares import invert_symmetric, robust_step


@pytest.mark.parametrize('scales', [np.ones(1), np.ones(2), np.ones(5), np.ones(12), [1e-6, 1.0, 1e6]])
def test_the_inverse_is_that_of_the_library_in_any_units(scales):
    size = len(scales)
    roots = np.random.default_rng(size).normal(size=(size + 2, size))
    inverse = np.empty((size, size))
    assert invert_symmetric((roots * scales).T @ (roots * scales), inverse)
    np.testing.assert_allclose(inverse * np.outer(scales, scales), np.linalg.inv(roots.T @ roots), rtol=1e-8)


@pytest.mark.parametrize('value', [0.0, np.nan])
def test_a_singular_matrix_has_no_inverse(value):
    jacobian = np.array([[1.0, 2.0], [3.0, 6.0], [2.0, 4.0]])
    inverse = np.empty((2, 2))
    assert not invert_symmetric(jacobian.T @ jacobian, inverse)
    assert not invert_symmetric(np.array([[1.0, 0.0], [0.0, value]]), inverse)


RNG = np.random.default_rng(0)
JACOBIAN = np.column_stack([np.ones(30), np.linspace(-1.0, 1.0, 30)])
NO_PRIOR = np.zeros(2)


def test_a_third_of_wild_offsets_does_not_move_it():
    offsets = JACOBIAN @ [0.3, -0.2] + 0.01 * RNG.standard_normal(30)
    offsets[::3] = 0.8
    fit = robust_step(JACOBIAN, offsets, np.full(30, 0.01), NO_PRIOR)
    assert fit.found
    np.testing.assert_allclose(fit.step, [0.3, -0.2], atol=0.02)
    assert fit.inlier_fraction == pytest.approx(20 / 30, abs=0.05)


def test_covariance_is_that_of_repeated_fits():
    steps, stated = [], []
    for _ in range(1000):
        fit = robust_step(JACOBIAN, 0.02 * RNG.standard_normal(30), np.full(30, 0.02), NO_PRIOR)
        steps.append(fit.step)
        stated.append(fit.covariance)
    np.testing.assert_allclose(np.cov(np.transpose(steps)), np.mean(stated, axis=0), rtol=0.2, atol=4e-6)


def test_covariance_grows_with_scatter_that_noise_does_not_explain():
    quiet = robust_step(JACOBIAN, 0.01 * RNG.standard_normal(30), np.full(30, 0.01), NO_PRIOR)
    rough = robust_step(JACOBIAN, 0.05 * RNG.standard_normal(30), np.full(30, 0.01), NO_PRIOR)
    assert rough.covariance[0, 0] > 8.0 * quiet.covariance[0, 0]


def test_too_few_offsets_are_no_fit():
    sigmas = np.full(30, np.inf)
    sigmas[:2] = 0.01
    assert not robust_step(JACOBIAN, np.zeros(30), sigmas, NO_PRIOR).found


def test_an_unobservable_parameter_stays_at_its_prior():
    rank_deficient = np.column_stack([np.ones(30), np.zeros(30)])
    fit = robust_step(rank_deficient, np.full(30, 0.1), np.full(30, 0.01), np.array([0.0, 1.0]))
    np.testing.assert_allclose(fit.step, [0.1, 0.0], atol=1e-9)
    assert fit.covariance[1, 1] == pytest.approx(1.05, rel=0.01)
