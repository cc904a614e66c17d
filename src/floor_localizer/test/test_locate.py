import csv
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

from floor_localizer.commands.locate import main
from floor_localizer.core.dots import DotMap
from floor_localizer.files.csv_format import save_csv
from scene_simulator.floor.camera import PAPER_CAMERA, FloorCamera
from scene_simulator.floor.dot_floor import FloorDesign, generate_dot_floor
from scene_simulator.messages import camera_info, compressed_image, odometry
from shirube_bags.bag_writer import BagWriter
from shirube_bags.trajectory_files import load_tum
from shirube_core.geometry import SE2, CameraMount

MOUNT = CameraMount(xyz=(0.03, -0.01, 0.13))
START_NS = 1_700_000_000_123_456_789
STEP_NS = 100_000_000
TRUTH = [SE2(0.12 + 0.02 * k, 0.15 + 0.01 * k, 0.4 + 0.05 * k) for k in range(8)]
BLANK = 5  # index of the image without dots


@pytest.fixture(scope='module')
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a map, a calibration, images and a bag of the same images."""
    folder = tmp_path_factory.mktemp('scene')
    floor = generate_dot_floor(FloorDesign(size=(0.5, 0.5), count=1346), seed=1)
    save_csv(folder / 'floor.csv', DotMap(floor.points, floor.diameters))
    rng, camera = np.random.default_rng(1), FloorCamera()
    images = [camera.photograph(floor, [pose], mount=MOUNT, rng=rng).image for pose in TRUTH]
    images[BLANK] = np.full_like(images[0], 200)
    (folder / 'images').mkdir()
    for number, image in enumerate(images):
        cv2.imwrite(str(folder / 'images' / f'{number:03d}.png'), image)
    (folder / 'camera.yaml').write_text(yaml.safe_dump(calibration()))
    with BagWriter(folder / 'bag') as bag:
        for number, (image, pose) in enumerate(zip(images, TRUTH)):
            stamp = START_NS + number * STEP_NS
            info = camera_info(PAPER_CAMERA, 'camera', stamp)
            bag.write('/camera_info', 'sensor_msgs/msg/CameraInfo', info, stamp)
            bag.write('/odom', 'nav_msgs/msg/Odometry', odometry(pose, (0.2, 0.5), stamp), stamp)
            message = compressed_image(image, 'camera', stamp)
            if number == 2:
                message.data = message.data[:-100]
            bag.write('/image_raw/compressed', 'sensor_msgs/msg/CompressedImage', message, stamp)
    return folder


def calibration() -> dict[str, Any]:
    return {
        'image_width': PAPER_CAMERA.width,
        'image_height': PAPER_CAMERA.height,
        'camera_matrix': {'rows': 3, 'cols': 3, 'data': PAPER_CAMERA.matrix.ravel().tolist()},
        'distortion_model': 'plumb_bob',
        'distortion_coefficients': {'rows': 1, 'cols': 5, 'data': list(PAPER_CAMERA.distortion)},
    }


Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    def locate(*arguments: object) -> tuple[int, str, str]:
        xyz = [str(number) for number in MOUNT.xyz]
        given = ['--out', str(tmp_path / 'out'), '--camera-xyz', *xyz, *map(str, arguments)]
        if '--map' not in given:
            given += ['--map', str(scene / 'floor.csv')]
        capsys.readouterr()
        code = main(given)
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return locate


def check_against_truth(path: Path, numbers: list[int]) -> None:
    trajectory = load_tum(path)
    truth = [TRUTH[number] for number in numbers]
    assert len(trajectory) == len(truth)
    xy = np.array([(pose.x, pose.y) for pose in truth])
    assert np.hypot(*(trajectory.positions[:, :2] - xy).T).max() < 0.0003
    yaws = 2.0 * np.arctan2(trajectory.quaternions[:, 2], trajectory.quaternions[:, 3])
    assert np.abs(yaws - [pose.yaw for pose in truth]).max() < 0.005


def test_a_rendered_folder_agrees_with_the_truth(scene: Path, run: Run, tmp_path: Path) -> None:
    code, out, _ = run('--images', scene / 'images', '--calibration', scene / 'camera.yaml')
    assert code == 0
    assert '7 of 8 images have a pose' in out
    seen = [number for number in range(8) if number != BLANK]
    check_against_truth(tmp_path / 'out' / 'poses.tum', seen)
    np.testing.assert_array_equal(
        load_tum(tmp_path / 'out' / 'poses.tum').stamps_ns, np.array(seen) * 1_000_000_000
    )
    with (tmp_path / 'out' / 'poses.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert [bool(row['reason']) for row in rows] == [number == BLANK for number in range(8)]
    assert rows[BLANK]['reason'] == 'no dots on the floor'
    assert rows[0]['image'].endswith('000.png')
    assert abs(float(rows[3]['x']) - TRUTH[3].x) < 0.0003
    assert 0.0 < float(rows[3]['sigma_x']) < 0.0003


def test_a_bag_agrees_with_the_truth_and_a_bad_image_in_it_is_no_end(scene, run, tmp_path):
    code, out, _ = run('--bag', scene / 'bag')
    assert code == 0
    assert '6 of 8 images have a pose' in out
    assert 'is truncated' in out
    seen = [number for number in range(8) if number not in (2, BLANK)]
    check_against_truth(tmp_path / 'out' / 'poses.tum', seen)
    np.testing.assert_array_equal(
        load_tum(tmp_path / 'out' / 'poses.tum').stamps_ns, START_NS + np.array(seen) * STEP_NS
    )


def test_images_of_another_floor_have_no_pose_and_leave_no_old_file(scene, run, tmp_path):
    other = generate_dot_floor(FloorDesign(size=(0.5, 0.5), count=1346), seed=2)
    save_csv(tmp_path / 'other.csv', DotMap(other.points, other.diameters))
    (tmp_path / 'out').mkdir()
    (tmp_path / 'out' / 'poses.tum').write_text('old')
    images = sorted((scene / 'images').iterdir())[:2]
    code, _, err = run(
        '--images', *images, '--calibration', scene / 'camera.yaml', '--map', tmp_path / 'other.csv'
    )
    assert code == 1
    assert 'no image has a pose' in err
    assert not (tmp_path / 'out' / 'poses.tum').exists()
    assert (tmp_path / 'out' / 'poses.csv').exists()


@pytest.mark.parametrize(
    ('arguments', 'part'),
    [
        ('--images {0}/images', '--calibration is missing'),
        ('--images {0}/none --calibration {0}/camera.yaml', 'none: does not exist'),
        ('--images {0}/images --calibration {0}/none.yaml', 'none.yaml: cannot be read'),
        ('--images {0}/images --calibration {0}/floor.csv', 'floor.csv: holds no fields'),
        ('--images {0}/floor.csv --calibration {0}/camera.yaml', 'floor.csv: is no image'),
        ('--images {0}/images --calibration {0}/camera.yaml --map {0}/none.csv', 'none.csv: cannot be read'),
        ('--images {0}/images --calibration {0}/camera.yaml --camera-xyz 0 0 99', 'camera_xyz'),
        (
            '--images {0}/images --calibration {0}/camera.yaml --out {0}/floor.csv/x',
            'choose a writable place',
        ),
        ('--bag {0}/none', 'none: does not exist'),
        ('--bag {0}/images', 'is a folder without metadata.yaml'),
        ('--bag {0}/bag --topic /none', 'has no topic /none'),
        ('--bag {0}/bag --topic /odom', 'topic /odom is nav_msgs/msg/Odometry, no Image'),
    ],
)
def test_bad_input_is_one_line_and_exit_code_1(scene: Path, run: Run, arguments: str, part: str) -> None:
    code, _, err = run(*arguments.format(scene).split())
    assert code == 1
    lines = [line for line in err.splitlines() if line.startswith('locate: ')]
    assert len(lines) == 1
    assert part in lines[0]


def test_an_image_of_another_size_than_the_calibration_is_refused(scene, run, tmp_path):
    cv2.imwrite(str(tmp_path / 'small.png'), np.zeros((100, 120), dtype=np.uint8))
    code, _, err = run('--images', tmp_path / 'small.png', '--calibration', scene / 'camera.yaml')
    assert code == 1
    assert 'is 120 x 100 px, the calibration is for 235 x 235 px' in err


@pytest.mark.newest_set_only
def test_no_rclpy_is_imported() -> None:
    code = 'import sys, floor_localizer.commands.locate; sys.exit("rclpy" in sys.modules)'
    assert subprocess.run([sys.executable, '-c', code], check=False).returncode == 0
