import numpy as np
import pytest
from lamp_pictures import blinking_rows, draw_lamp, photograph, room

from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.settings import LampSettings

ROW_TIME, EXPOSURE = 1.89e-5, 6e-5


@pytest.mark.parametrize(('radius', 'tone'), [(8.25, 3500.0), (8.25, 7500.0), (40.0, 2000.0), (100.0, 2000.0)])
def test_the_centre_does_not_follow_the_stripes(radius, tone):
    rng = np.random.default_rng(1)
    detector = LampDetector(LampSettings(stripe_rows=1.0 + 0.5 / tone / ROW_TIME, diameter_max=300.0))
    errors, normalised = [], []
    for phase in rng.uniform(0.0, 1.0 / tone, 20 if radius < 20.0 else 6):
        place = np.array([200.0, 150.0]) + rng.uniform(0.0, 1.0, 2)
        rows = blinking_rows(tone, ROW_TIME, EXPOSURE, phase)
        picture = draw_lamp(room(), place, radius, 180.0, rows=rows)
        blobs = detector.detect(photograph(picture, 1.5, rng))
        assert len(blobs) == 1
        errors.append(blobs.centroids[0] - place)
        normalised.append(errors[-1] / blobs.sigmas[0])
        assert blobs.radii[0] == pytest.approx(radius, abs=0.5 + 0.02 * radius)
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    assert rms[0] < 0.12
    assert rms[1] < 0.35
    assert np.sqrt(np.mean(np.square(normalised))) < 2.0
