"""A short image sequence under four lamps processed by ``locate``, as images and as a bag."""

import csv
import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from lamp_scenes import BEACONS, CAMERA, MOUNT, id_packets, speaking_room, write_messages

from scene_simulator import messages
from scene_simulator.imaging.exposure import Shutter
from scene_simulator.robot.leg_drive import Suspension, TiltReading
from shirube_bags.bag_reader import jazzy_types
from shirube_bags.bag_writer import BagWriter
from shirube_bags.trajectory_files import load_tum
from shirube_core.geometry import SE2
from vlc_beacon.commands.locate import main
from vlc_beacon.core.light_code.rs_fsk import rs_fsk_waveform
from vlc_beacon.core.packet.data_packet import split_message
from vlc_beacon.files.beacons_file import save_beacons

START_NS = 1_700_000_000_123_456_789
RATE, SECONDS = 60.0, 2.6
SHUTTER = Shutter(6e-5, 18.9e-6)
EXPOSURE = ('--shutter', 'rolling', '--exposure-time', '6e-5', '--row-time', '18.9e-6')
LIGHT = (*EXPOSURE, '--lamp-frame-rate', RATE)
TEXT = '診察室'
DAMAGED = 3


CALIBRATION = {
    'image_width': CAMERA.width,
    'image_height': CAMERA.height,
    'camera_matrix': {'rows': 3, 'cols': 3, 'data': CAMERA.matrix.ravel().tolist()},
    'distortion_model': 'plumb_bob',
    'distortion_coefficients': {'rows': 1, 'cols': 5, 'data': [0.0] * 5},
}


def content_of(stamp: int, pixels: np.ndarray, pose: SE2) -> dict[str, object]:
    """Return the messages of a grey image and of its time."""
    info, kind = messages.camera_info(CAMERA, 'ceiling_optical_frame', stamp), 'sensor_msgs/msg/Image'
    height, width = pixels.shape
    size = {'height': height, 'width': width, 'step': width, 'encoding': 'mono8', 'is_bigendian': 0}
    return {
        '/camera_info': info,
        '/imu': messages.imu(TiltReading(0.0, 0.0, 0.0), 'base_link', stamp),
        '/odom': messages.odometry(pose, (0.0, 0.0), stamp),
        '/image_raw': jazzy_types().types[kind](header=info.header, **size, data=pixels.ravel()),
    }


@pytest.fixture(scope='module')
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with beacons, a calibration, images, a bag of the same images and the truth."""
    folder = tmp_path_factory.mktemp('film')
    packets = [[packet] for packet in id_packets()]
    packets[0] += [packet.to_bytes() for packet in split_message(TEXT)] + packets[0]
    drive = speaking_room([rs_fsk_waveform(each, RATE) for each in packets], SHUTTER, RATE)
    drive = replace(drive, suspension=Suspension(0.0, 0.0))
    save_beacons(folder / 'beacons.yaml', BEACONS)
    (folder / 'camera.yaml').write_text(yaml.safe_dump(CALIBRATION))
    (folder / 'images').mkdir()
    truth = []
    wheels = {round(reading.time * 1e9): reading.pose for reading in drive.odometry(SECONDS, 1.0 / RATE)}
    with BagWriter(folder / 'bag') as bag:
        for number, (frame, pose) in enumerate(zip(drive.frames(SECONDS), wheels.values(), strict=True)):
            pixels = frame.photo.image
            cv2.imwrite(str(folder / 'images' / f'{number:03d}.png'), pixels)
            stamp = START_NS + round(frame.stamp * 1e9)
            write_messages(bag, stamp, content_of(stamp, pixels[:-40] if number == DAMAGED else pixels, pose))
            truth.append((frame.pose.x, frame.pose.y))
    np.savetxt(folder / 'truth.txt', truth)
    return folder


Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(film: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs the command; returns its exit code, output and errors."""
    files = ('--beacons', film / 'beacons.yaml', '--out', tmp_path / 'out')
    given = (*files, '--camera-xyz', *MOUNT.xyz, *LIGHT)

    def locate(*arguments: object) -> tuple[int, str, str]:
        capsys.readouterr()
        return main([str(argument) for argument in (*given, *arguments)]), *capsys.readouterr()

    return locate


def errors(path: Path, film: Path, start_ns: int) -> np.ndarray:
    trajectory, truth = load_tum(path), np.loadtxt(film / 'truth.txt')
    numbers = np.round((trajectory.stamps_ns - start_ns) * 1e-9 * RATE).astype(int)
    assert len(numbers) > 5
    return np.hypot(*(trajectory.positions[:, :2] - truth[numbers]).T)


def test_a_rendered_folder_agrees_with_the_truth(film: Path, run: Run, tmp_path: Path) -> None:
    given = ('--images', film / 'images', '--calibration', film / 'camera.yaml', '--camera-height-known')
    assert run(*given, '--rate', RATE)[0] == 0
    assert errors(tmp_path / 'out' / 'poses.tum', film, 0).max() < 0.005
    with (tmp_path / 'out' / 'poses.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert rows[0]['reason'] == 'no known lamp in view'
    assert rows[-1]['beacons'] == '1 2 3 4'
    assert int(rows[-1]['used']) >= 3
    assert 0.0 < float(rows[-1]['sigma_x']) < 0.02


def test_a_bag_agrees_with_the_truth_and_a_bad_image_is_no_end(film: Path, run: Run, tmp_path: Path) -> None:
    code, out, _ = run('--bag', film / 'bag')
    assert code == 0
    assert '1 without a pose: /image_raw' in out
    # What a lamp says appears as well, with its sender once that is known.
    data = tmp_path / 'out' / 'data.csv'
    assert f'messages of lamps; see {data}' in out
    said = [json.loads(row['data']) for row in csv.DictReader(data.open())]
    assert {message['text'] for message in said} == {TEXT}
    assert {message['beacon'] for message in said} <= {None, 1}
    assert errors(tmp_path / 'out' / 'poses.tum', film, START_NS).max() < 0.005


def test_other_beacons_give_no_pose_and_leave_no_old_file(film: Path, run: Run, tmp_path: Path) -> None:
    other = tmp_path / 'other.yaml'
    other.write_text('beacons: [{id: 77, xyz: [0.0, 0.0, 2.5], radius: 0.03}]')
    (tmp_path / 'out').mkdir()
    (tmp_path / 'out' / 'poses.tum').write_text('old')
    images = sorted((film / 'images').iterdir())[:3]
    code, _, err = run('--images', *images, '--calibration', film / 'camera.yaml', '--beacons', other)
    assert code == 1
    assert 'no image gave a pose' in err
    assert not (tmp_path / 'out' / 'poses.tum').exists()
    assert (tmp_path / 'out' / 'poses.csv').exists()


@pytest.mark.parametrize(
    ('arguments', 'part'),
    [
        ('--images {0}/images', '--calibration is missing'),
        ('--images {0}/none --calibration {0}/camera.yaml', 'none: does not exist'),
        ('--images {0}/images --calibration {0}/camera.yaml --rate 0', '--rate is 0.0'),
        ('--images {0}/images --calibration {0}/camera.yaml --beacons {0}/none.yaml', 'cannot be read'),
        ('--images {0}/images --calibration {0}/camera.yaml --shutter slow', 'shutter is'),
        ('--images {0}/images --calibration {0}/camera.yaml --camera-rpy 3.1 0 0', 'does not look up'),
        ('--bag {0}/none', 'none: does not exist'),
        ('--bag {0}/bag --topic /odom', 'topic /odom is nav_msgs/msg/Odometry, no Image'),
    ],
)
def test_bad_input_is_one_line_and_exit_code_1(film: Path, run: Run, arguments: str, part: str) -> None:
    code, _, err = run(*arguments.format(film).split())
    assert code == 1
    (line,) = [line for line in err.splitlines() if line.startswith('locate: ')]
    assert part in line


@pytest.mark.newest_set_only
def test_no_rclpy_is_imported() -> None:
    code = 'import sys, vlc_beacon.commands.locate; sys.exit("rclpy" in sys.modules)'
    assert subprocess.run([sys.executable, '-c', code], check=False).returncode == 0
