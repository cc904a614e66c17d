import numpy as np
import pytest
from lamp_pictures import photograph
from scipy.special import expit

from vlc_beacon.core.lamp_image.blooming import calibrate_blooming, fit_blooming
from vlc_beacon.core.vlc_beacon_error import LampImageError

# What the notes of one real lamp say: [1/px], [px], [grey levels].
ALPHA, BETA, GAMMA = 2.4, 2.5, 48.0
CENTRE = np.array([60.3, 59.6])
FOCAL, LAMP_RADIUS = 636.4, 0.0325


def blooming_image(depth, rng=None):
    """Return an image of eq. (4) corrected, written out here once more."""
    p = LAMP_RADIUS * FOCAL / depth
    v, u = np.mgrid[0:120, 0:120]
    distance = np.hypot(u - CENTRE[0], v - CENTRE[1])
    outside = (220.0 - GAMMA) * (1.0 - expit(ALPHA * (distance - p - BETA))) + GAMMA
    return photograph(np.where(distance <= p, 220.0, outside), 1.5, rng), p


def test_the_curve_is_found_again():
    image, p = blooming_image(2.5, np.random.default_rng(1))
    fit = fit_blooming(image, CENTRE, 9.0)
    assert fit.half_maximum_radius == pytest.approx(p + BETA, abs=0.03)
    assert fit.alpha == pytest.approx(ALPHA, rel=0.1)
    assert fit.gamma == pytest.approx(GAMMA, abs=0.5)
    assert fit.brightness == pytest.approx(220.0, abs=1.0)


def test_a_known_distance_parts_radius_and_blooming():
    rng = np.random.default_rng(2)
    depths = [1.5, 2.0, 2.5]
    fits = [fit_blooming(blooming_image(depth, rng)[0], CENTRE, 10.0) for depth in depths]
    calibration = calibrate_blooming(fits, depths, LAMP_RADIUS, FOCAL)
    assert calibration.beta == pytest.approx(BETA, abs=0.05)
    assert calibration.beta_sigma < 0.05
    image, p = blooming_image(3.2, rng)
    radius = fit_blooming(image, CENTRE, 9.0).half_maximum_radius - calibration.beta
    assert radius == pytest.approx(p, abs=0.06)
    assert LAMP_RADIUS * FOCAL / radius == pytest.approx(3.2, rel=0.01)


def test_invalid_fits_are_rejected():
    image, _ = blooming_image(2.5)
    with pytest.raises(LampImageError, match='cut off'):
        fit_blooming(image, np.array([5.0, 60.0]), 9.0)
    with pytest.raises(LampImageError, match='no lamp'):
        fit_blooming(np.zeros_like(image), CENTRE, 9.0)
    fit = fit_blooming(image, CENTRE, 9.0)
    with pytest.raises(LampImageError, match='one depth for each'):
        calibrate_blooming([fit], [2.0, 3.0], LAMP_RADIUS, FOCAL)
    with pytest.raises(LampImageError, match='not positive'):
        calibrate_blooming([fit], [0.0], LAMP_RADIUS, FOCAL)
