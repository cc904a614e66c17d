import numpy as np
import pytest

from vlc_beacon.core.lamp_image.lamp_track import ImageMotion


def test_a_steady_motion_is_expected():
    motion = ImageMotion(0.0, np.array([10.0, 20.0]), 1.0)
    for k in range(1, 40):
        motion.update(k / 60.0, np.array([10.0 + 3.0 * k, 20.0 - k]), 0.1)
    position, sigma = motion.predict(40 / 60.0)
    assert position == pytest.approx([130.0, -20.0], abs=0.05)
    assert sigma < 0.5


def test_the_longer_the_lamp_is_dark_the_less_is_known():
    motion = ImageMotion(0.0, np.array([10.0, 20.0]), 1.0)
    sigmas = [motion.predict(stamp)[1] for stamp in (0.0, 0.1, 0.2, 0.4)]
    assert sigmas == sorted(sigmas)
    motion.coast(0.2)
    assert motion.predict(0.2)[1] == pytest.approx(sigmas[2])
