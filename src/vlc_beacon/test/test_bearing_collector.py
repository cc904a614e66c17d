import math

import numpy as np
import pytest
from lamp_pictures import draw_lamp, photograph, room

from shirube_core.geometry import PinholeCamera, matrix_from_rpy
from vlc_beacon.core.light_code.rs_fsk import rs_fsk_waveform
from vlc_beacon.core.packet.data_packet import IdPacket
from vlc_beacon.core.settings import ReceiverSettings
from vlc_beacon.core.survey.beacon_survey import BearingCollector, image_rotation, survey_lamp

CAMERA = PinholeCamera(640, 480, 300.0, 300.0, 319.5, 239.5)
UP = matrix_from_rpy((0.0, 0.0, 0.5 * math.pi))


@pytest.mark.parametrize('turn', [-0.5, 0.1, 1.2])
def test_a_lamp_goes_round_the_middle_by_the_turn_of_the_image(turn: float) -> None:
    """Whichever way the camera is mounted, as long as it looks up."""
    rotations = [matrix_from_rpy((0.0, 0.0, yaw)) @ UP for yaw in (0.4, 0.4 + turn)]
    points = [rotation.T @ np.array([0.7, -0.3, 2.5]) for rotation in rotations]
    before, after = (math.atan2(v - CAMERA.cy, u - CAMERA.cx) for u, v in CAMERA.pixels_from_points(points))
    assert image_rotation(*rotations) == pytest.approx(math.remainder(after - before, math.tau))


ROLLING = ReceiverSettings(shutter='rolling', row_time=3e-5, exposure_time=6e-5)
LAMP, BEACON = np.array([1.0, 0.3, 2.5]), 77


def camera_at(time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return position and ``R_map_camera`` on a drive past the lamp."""
    place = np.array([0.5 * time - 0.25, 0.2 + 0.1 * math.sin(time), 0.0])
    return place, matrix_from_rpy((0.0, 0.0, 0.4 * math.sin(2.0 * time))) @ UP


@pytest.mark.newest_set_only
def test_rows_are_seen_from_where_the_camera_was_then() -> None:
    """A rolling shutter reaches the lamp 7 ms after the stamp, when the camera is 3.5 mm farther on."""
    light, rng = rs_fsk_waveform([IdPacket(BEACON).to_bytes()], 30.0), np.random.default_rng(3)
    watch = BearingCollector(CAMERA, ROLLING)
    for stamp in np.arange(0.0, 5.0, 1.0 / 30.003).tolist():
        centre = np.array([CAMERA.cx, CAMERA.cy])
        for _ in range(3):
            position, rotation = camera_at(stamp + centre[1] * ROLLING.row_time)
            (centre,) = CAMERA.pixels_from_points([rotation.T @ (LAMP - position)])
        rows = light.exposure_means(stamp + np.arange(CAMERA.height) * 3e-5, 6e-5)[:, 0]
        picture = draw_lamp(room(CAMERA.height, CAMERA.width), centre, 12.0, 180.0, rows=rows.__getitem__)
        watch.add(stamp, photograph(picture, 1.0, rng), *camera_at(stamp))
    (beacon, bearings), *others = watch.bearings().items()
    assert (beacon, others) == (BEACON, [])
    lamp = survey_lamp(bearings, 0.0)
    assert lamp.xyz[:2] == pytest.approx(LAMP[:2], abs=0.001)
    assert (np.abs(np.array(lamp.xyz) - LAMP) < 4.0 * lamp.sigma + 1e-4).all()
