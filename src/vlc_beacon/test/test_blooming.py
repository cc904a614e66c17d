import lamp_pictures
import numpy as np
import pytest
from lamp_pictures import ALPHA, BETA, FOCAL, LAMP_RADIUS

from vlc_beacon.core.lamp_image.blooming import calibrate_blooming, fit_blooming
from vlc_beacon.core.vlc_beacon_error import LampImageError

CENTRE = np.array([60.3, 59.6])


def blooming_image(depth, rng=None):
    return lamp_pictures.blooming_image((120, 120), CENTRE, depth, 48.0, rng)


def test_the_curve_is_found_again():
    image, p = blooming_image(2.5, np.random.default_rng(1))
    fit = fit_blooming(image, CENTRE, 9.0)
    assert fit.half_maximum_radius == pytest.approx(p + BETA, abs=0.03)
    assert fit.alpha == pytest.approx(ALPHA, rel=0.1)
    assert fit.gamma == pytest.approx(48.0, abs=0.5)
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
    for words, bad_image, centre in (('cut off', image, [5.0, 60.0]), ('no lamp', 0 * image, CENTRE)):
        with pytest.raises(LampImageError, match=words):
            fit_blooming(bad_image, np.array(centre), 9.0)
    fit = fit_blooming(image, CENTRE, 9.0)
    for words, depths in (('one depth for each', [2.0, 3.0]), ('not positive', [0.0])):
        with pytest.raises(LampImageError, match=words):
            calibrate_blooming([fit], depths, LAMP_RADIUS, FOCAL)
