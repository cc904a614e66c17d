import numpy as np
import pytest

from stereo_landmark.core.edges.edges import gaussian_gradient


@pytest.mark.parametrize('sigma', [0.7, 1.0, 2.5])
def test_a_ramp_has_its_slope_everywhere(sigma):
    y, x = np.indices((60, 70))
    gx, gy = gaussian_gradient((20 + 2 * x + y).astype(np.uint8), sigma)
    np.testing.assert_allclose(gx[10:-10, 10:-10], 2.0, atol=1e-4)
    np.testing.assert_allclose(gy[10:-10, 10:-10], 1.0, atol=1e-4)


def test_noise_is_reduced_as_the_filter_predicts():
    image = np.clip(128 + 10 * np.random.default_rng(0).standard_normal((300, 300)), 0, 255).astype(np.uint8)
    gx, _ = gaussian_gradient(image, 1.5)
    assert gx.std() == pytest.approx(10.0 / (np.sqrt(8.0 * np.pi) * 1.5**2), rel=0.05)
