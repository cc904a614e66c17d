import numpy as np
import pytest

from stereo_landmark.core.least_squares import invert_symmetric


def random_matrix(seed, size, scales):
    roots = np.random.default_rng(seed).normal(size=(size + 2, size)) * scales
    return roots.T @ roots


@pytest.mark.parametrize('size', [1, 2, 5, 12])
def test_the_inverse_is_that_of_the_library(size):
    matrix = random_matrix(size, size, np.ones(size))
    inverse = np.empty((size, size))
    assert invert_symmetric(matrix, inverse)
    np.testing.assert_allclose(inverse, np.linalg.inv(matrix), rtol=1e-8)


def test_units_do_not_matter():
    scales = np.array([1e-6, 1.0, 1e6])
    inverse = np.empty((3, 3))
    assert invert_symmetric(random_matrix(1, 3, scales), inverse)
    np.testing.assert_allclose(
        inverse * scales * scales[:, None], np.linalg.inv(random_matrix(1, 3, np.ones(3))), rtol=1e-6
    )


@pytest.mark.parametrize('value', [0.0, np.nan])
def test_a_singular_matrix_has_no_inverse(value):
    jacobian = np.array([[1.0, 2.0], [3.0, 6.0], [2.0, 4.0]])
    inverse = np.empty((2, 2))
    assert not invert_symmetric(jacobian.T @ jacobian, inverse)
    assert not invert_symmetric(np.array([[1.0, 0.0], [0.0, value]]), inverse)
