import numpy as np
import pytest
from lamp_room import CAMERA

from shirube_core.geometry import SE2, PinholeCamera
from vlc_beacon.core.pose.lamp_rays import lamp_rays, row_motions

FISHY = PinholeCamera(1280, 1024, 636.4, 640.0, 639.5, 511.5, (-0.25, 0.06, 0.001, -0.001, 0.0))


@pytest.mark.parametrize('camera', [CAMERA, FISHY])
def test_covariances_are_those_of_rays_of_noisy_centres(camera):
    rng = np.random.default_rng(1)
    for pixel in ([640.0, 500.0], [1150.0, 900.0]):
        rays = lamp_rays(camera, [1], [pixel], [0.4])
        noisy = camera.rays_from_pixels(pixel + 0.5 * rng.normal(size=(40000, 2)))[:, :2]
        # 0.4 px of the centre and 0.3 px of the calibration are 0.5 px together.
        assert rays.covariances(0.3)[0] == pytest.approx(np.cov(noisy.T), rel=0.1, abs=3e-8)


def test_rows_are_seen_from_where_the_robot_got_to():
    velocity, row_time, rows = (0.7, -0.2, 1.1), 2e-5, np.array([0.0, 300.0, 1000.0])
    motions = row_motions(rows, row_time, velocity)
    for row, motion in zip(rows, motions):
        moved, steps = SE2(0.0, 0.0, 0.0), 2000
        for _ in range(steps):
            moved = moved @ SE2(*(row * row_time / steps * np.array(velocity)))
        assert motion == pytest.approx([moved.x, moved.y, moved.yaw], abs=1e-6)


def test_only_ids_twice_in_one_image_are_duplicates():
    rays = lamp_rays(CAMERA, [1, 2, 1, 3], np.full((4, 2), 500.0), np.ones(4))
    assert rays.is_duplicate.tolist() == [True, False, True, False]
    assert not rays.subset(np.array([True, True, False, True])).is_duplicate.any()
