import numpy as np
import pytest
from drawn_floor import disc_coverage, photograph, scattered_centres

from floor_localizer.core.dot_extraction.coverage import noise_at

MIDDLE = np.array([[80, 80]])


@pytest.mark.parametrize('noise', [0.7, 1.5, 4.0, 10.0])
@pytest.mark.parametrize('channels', [1, 3])
def test_measures_the_noise_under_dots_and_gradient(noise, channels):
    light = np.linspace(0.6, 1.3, 160)[None, :]
    coverage = disc_coverage(scattered_centres(4), 7.0)
    image = np.stack(
        [photograph(coverage, light=light, noise=noise, seed=c) for c in range(channels)], axis=2
    )
    pixels = np.array([[u, v] for u in (0, 60, 159) for v in (0, 60, 159)])
    np.testing.assert_allclose(noise_at(image, pixels).mean(), np.hypot(noise, 12.0**-0.5), rtol=0.2)


def test_noise_is_measured_locally():
    image = photograph(np.zeros((160, 160)), noise=1.0)
    image[96:, 96:] = photograph(np.zeros((64, 64)), noise=6.0, seed=1)
    quiet, noisy = noise_at(image[..., None], np.array([[10, 10], [150, 150]]))
    assert noisy > 4.0 * quiet


def test_is_never_less_than_rounding():
    assert noise_at(np.full((40, 40, 1), 7, np.uint8), np.array([[20, 20]]))[0] == pytest.approx(12.0**-0.5)
