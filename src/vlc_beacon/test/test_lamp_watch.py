import math

import numpy as np
import pytest

from shirube_geometry import PinholeCamera, matrix_from_rpy
from vlc_beacon.core.survey.lamp_watch import image_turn

CAMERA = PinholeCamera(640, 480, 300.0, 300.0, 319.5, 239.5)


@pytest.mark.parametrize('turn', [-0.5, 0.1, 1.2])
def test_a_lamp_goes_round_the_middle_by_the_turn_of_the_image(turn: float) -> None:
    """Whichever way the camera is mounted, as long as it looks up."""
    angles = []
    for yaw in (0.4, 0.4 + turn):
        rotation = matrix_from_rpy((0.0, 0.0, yaw)) @ matrix_from_rpy((0.0, 0.0, 0.5 * math.pi))
        (pixel,) = CAMERA.pixels_from_points([rotation.T @ np.array([0.7, -0.3, 2.5])])
        angles.append((math.atan2(pixel[1] - CAMERA.cy, pixel[0] - CAMERA.cx), rotation))
    seen = math.remainder(angles[1][0] - angles[0][0], math.tau)
    assert image_turn(angles[0][1], angles[1][1]) == pytest.approx(seen)
