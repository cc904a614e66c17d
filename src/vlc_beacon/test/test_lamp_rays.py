import numpy as np
import pytest
from lamp_room import CAMERA

from shirube_core.geometry import PinholeCamera
from vlc_beacon.core.pose.lamp_rays import lamp_rays

FISHY = PinholeCamera(1280, 1024, 636.4, 640.0, 639.5, 511.5, (-0.25, 0.06, 0.001, -0.001, 0.0))


@pytest.mark.parametrize('camera', [CAMERA, FISHY])
def test_covariances_are_those_of_rays_of_noisy_centres(camera):
    rng = np.random.default_rng(1)
    for pixel in ([640.0, 500.0], [1150.0, 900.0]):
        rays = lamp_rays(camera, [1], [pixel], [0.4])
        noisy = camera.rays_from_pixels(pixel + 0.5 * rng.normal(size=(40000, 2)))[:, :2]
        # 0.4 px of the centre and 0.3 px of the calibration are 0.5 px together.
        assert rays.covariances(0.3)[0] == pytest.approx(np.cov(noisy.T), rel=0.1, abs=3e-8)
