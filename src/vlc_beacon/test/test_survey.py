"""A simulated drive under one lamp, rendered to a bag, gives the lamp's position."""

import math
from pathlib import Path

import numpy as np
import pytest
from lamp_pictures import draw_lamp, photograph, room
from lamp_scenes import write_messages

from scene_simulator import messages
from scene_simulator.robot.leg_drive import TiltReading
from shirube_bags.bag_writer import BagWriter
from shirube_core.geometry import SE2, PinholeCamera, matrix_from_rpy
from vlc_beacon.commands import survey
from vlc_beacon.core.light_code.ufsook import ufsook_waveform
from vlc_beacon.core.packet.data_packet import IdPacket
from vlc_beacon.files.beacons_file import load_beacons

pytestmark = pytest.mark.newest_set_only

CAMERA = PinholeCamera(320, 240, 160.0, 160.0, 159.5, 119.5)
LAMP, RADIUS, BEACON = np.array([1.3, 0.7, 2.5]), 0.15, 77
SECONDS, RATE, START_NS = 8.0, 60.004, 1_000_000_000
LIGHT = ufsook_waveform([IdPacket(BEACON).to_bytes()])


def pose_at(time: float) -> SE2:
    return SE2(0.6 + 0.2 * time, 0.6 + 0.3 * math.sin(time), 0.5 * math.sin(0.8 * time))


def tilt_at(time: float) -> tuple[float, float]:
    return 0.03 * math.sin(1.1 * time), 0.02 * math.cos(0.7 * time)


def picture_at(time: float, rng: np.random.Generator) -> np.ndarray:
    """Return what a level-headed draughtsman sees: the lamp's middle exactly, its disc without perspective."""
    pose = pose_at(time)
    turn = matrix_from_rpy((*tilt_at(time), pose.yaw)) @ matrix_from_rpy((0.0, 0.0, 0.5 * math.pi))
    point = turn.T @ (LAMP - (pose.x, pose.y, 0.0))
    (centre,) = CAMERA.pixels_from_points([point])
    # The first half of the lamp is that with negative x in the map.
    towards = -turn[0, :2]
    first, second = LIGHT.exposure_means(time, 5e-4)
    picture = room(CAMERA.height, CAMERA.width)
    size, angle = RADIUS * CAMERA.fx / point[2], math.atan2(towards[1], towards[0])
    return photograph(draw_lamp(picture, centre, size, 200.0, halves=(first, second), angle=angle), 1.0, rng)


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path, rng = tmp_path_factory.mktemp('bags') / 'drive', np.random.default_rng(2)
    with BagWriter(path) as bag:
        for k in range(round(SECONDS * RATE)):
            time = k / RATE
            stamp = START_NS + round(time * 1e9)
            content = {
                '/ground_truth': messages.pose_stamped(pose_at(time), 'map', stamp),
                '/imu': messages.imu(TiltReading(time, *tilt_at(time)), 'base_link', stamp),
                '/camera_info': messages.camera_info(CAMERA, 'camera', stamp),
                '/image_raw/compressed': messages.compressed_image(picture_at(time, rng), 'camera', stamp),
            }
            write_messages(bag, stamp, content)
    return path


def run(*arguments: object) -> int:
    given = ('--lamp-radius', RADIUS, '--camera-xyz', 0, 0, 0, *arguments)
    return survey.main([str(argument) for argument in given])


def test_the_lamp_is_found_and_sigma_includes_the_unknown_tilt(bag: Path, tmp_path: Path, capsys) -> None:
    sigmas, out = [], tmp_path / 'beacons.yaml'
    for imu in ('', '/imu'):
        assert run(bag, '--tilt-sigma', 0, '--imu-topic', imu, '--out', out) == 0
        line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith('beacon 77'))
        sigmas.append(float(line.split('+-')[1].split()[0]))
    assert sigmas[0] > 4.0 * sigmas[1]
    (lamp,) = load_beacons(out)
    assert (lamp.id, lamp.radius, lamp.frequency) == (BEACON, RADIUS, None)
    assert lamp.xyz == pytest.approx(LAMP, abs=0.01)


def test_bad_input_ends_in_one_line(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = {
        'does not exist': [tmp_path / 'none'],
        'has no topic /pose': [bag, '--pose-topic', '/pose'],
        'has no topic /imuu': [bag, '--imu-topic', '/imuu'],
        'exposure_time is 2': [bag, '--exposure-time', '2'],
        '--lamp-radius is 3.25 m, it must be from': [tmp_path / 'none', '--lamp-radius', '3.25'],
        'no lamp was surveyed': [bag, '--camera-rpy', '3.14159', '0', '0'],
    }
    for complaint, arguments in bad.items():
        assert run(*arguments, '--out', tmp_path / 'beacons.yaml') == 1
        (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith('survey: ')]
        assert complaint in line
    assert not (tmp_path / 'beacons.yaml').exists()
