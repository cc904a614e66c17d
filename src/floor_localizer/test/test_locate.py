import csv
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from survey_scene import STEP_NS, write_image

from floor_localizer.commands.calibrate_camera import save_intrinsics
from floor_localizer.commands.locate import main
from floor_localizer.core.dots import DotMap
from floor_localizer.files.dot_map_file import save_csv
from scene_simulator.floor.camera import PAPER_CAMERA, FloorCamera
from scene_simulator.floor.dot_floor import FloorDesign, generate_dot_floor
from scene_simulator.messages import odometry
from shirube_bags.bag_writer import BagWriter
from shirube_bags.trajectory_files import load_tum
from shirube_core.geometry import SE2, CameraMount

MOUNT = CameraMount(xyz=(0.03, -0.01, 0.13))
START_NS = 1_700_000_000_123_456_789
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
    cv2.imwrite(str(folder / 'small.png'), np.zeros((100, 120), dtype=np.uint8))
    for number, image in enumerate(images):
        cv2.imwrite(str(folder / 'images' / f'{number:03d}.png'), image)
    save_intrinsics(folder / 'camera.yaml', PAPER_CAMERA)
    with BagWriter(folder / 'bag') as bag:
        for number, (image, pose) in enumerate(zip(images, TRUTH)):
            stamp = START_NS + number * STEP_NS
            bag.write('/odom', 'nav_msgs/msg/Odometry', odometry(pose, (0.2, 0.5), stamp), stamp)
            write_image(bag, image, stamp, -100 if number == 2 else None)
    return folder


@pytest.fixture
def locate(scene: Path, tmp_path: Path) -> tuple[object, ...]:
    """The command and the options of every run; options that follow win."""
    return main, '--out', tmp_path / 'out', '--camera-xyz', *MOUNT.xyz, '--map', scene / 'floor.csv'


def check_against_truth(path: Path, numbers: list[int], start_ns: int, step_ns: int) -> None:
    trajectory = load_tum(path)
    np.testing.assert_array_equal(trajectory.stamps_ns, start_ns + np.array(numbers) * step_ns)
    truth = [TRUTH[number] for number in numbers]
    assert len(trajectory) == len(truth)
    xy = np.array([(pose.x, pose.y) for pose in truth])
    assert np.hypot(*(trajectory.positions[:, :2] - xy).T).max() < 0.0003
    yaws = 2.0 * np.arctan2(trajectory.quaternions[:, 2], trajectory.quaternions[:, 3])
    assert np.abs(yaws - [pose.yaw for pose in truth]).max() < 0.005


def test_a_rendered_folder_agrees_with_the_truth(scene, locate, run, tmp_path):
    code, out, _ = run(*locate, '--images', scene / 'images', '--calibration', scene / 'camera.yaml')
    assert code == 0
    assert '7 of 8 images have a pose' in out
    seen = [number for number in range(8) if number != BLANK]
    check_against_truth(tmp_path / 'out' / 'poses.tum', seen, 0, 1_000_000_000)
    with (tmp_path / 'out' / 'poses.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert [bool(row['reason']) for row in rows] == [number == BLANK for number in range(8)]
    assert rows[BLANK]['reason'] == 'no dots on the floor'
    assert rows[0]['image'].endswith('000.png')
    assert abs(float(rows[3]['x']) - TRUTH[3].x) < 0.0003
    assert 0.0 < float(rows[3]['sigma_x']) < 0.0003


def test_a_bag_agrees_with_the_truth_and_a_bad_image_in_it_is_no_end(scene, locate, run, tmp_path):
    code, out, _ = run(*locate, '--bag', scene / 'bag')
    assert code == 0
    assert '6 of 8 images have a pose' in out
    assert 'is truncated' in out
    seen = [number for number in range(8) if number not in (2, BLANK)]
    check_against_truth(tmp_path / 'out' / 'poses.tum', seen, START_NS, STEP_NS)


def test_images_of_another_floor_have_no_pose_and_leave_no_old_file(scene, locate, refusal, tmp_path):
    other = generate_dot_floor(FloorDesign(size=(0.5, 0.5), count=1346), seed=2)
    save_csv(tmp_path / 'other.csv', DotMap(other.points, other.diameters))
    (tmp_path / 'out').mkdir()
    (tmp_path / 'out' / 'poses.tum').write_text('old')
    images = sorted((scene / 'images').iterdir())[:2]
    other = ('--calibration', scene / 'camera.yaml', '--map', tmp_path / 'other.csv')
    assert 'no image has a pose' in refusal(*locate, '--images', *images, *other, alone=False)
    assert not (tmp_path / 'out' / 'poses.tum').exists()
    assert (tmp_path / 'out' / 'poses.csv').exists()


@pytest.mark.parametrize(('arguments', 'part'), [
    ('--images images', '--calibration is missing'),
    ('--images none --calibration camera.yaml', 'none: does not exist'),
    ('--images images --calibration none.yaml', 'none.yaml: cannot be read'),
    ('--images images --calibration floor.csv', 'floor.csv: holds no fields'),
    ('--images floor.csv --calibration camera.yaml', 'floor.csv: is no image'),
    ('--images small.png --calibration camera.yaml', 'is 120 x 100 px, the calibration is for 235 x 235 px'),
    ('--images images --calibration camera.yaml --map none.csv', 'none.csv: cannot be read'),
    ('--images images --calibration camera.yaml --camera-xyz 0 0 99', 'camera_xyz'),
    ('--images images --calibration camera.yaml --out floor.csv/x', 'choose a writable place'),
    ('--bag none', 'none: does not exist'),
    ('--bag images', 'is a folder without metadata.yaml'),
    ('--bag bag --topic /none', 'has no topic /none'),
    ('--bag bag --topic /odom', 'topic /odom is nav_msgs/msg/Odometry, no Image'),
])  # fmt: skip
def test_bad_input_is_one_line_and_exit_code_1(scene, locate, refusal, monkeypatch, arguments, part):
    monkeypatch.chdir(scene)
    assert part in refusal(*locate, *arguments.split(), alone=False)


@pytest.mark.newest_set_only
def test_no_rclpy_is_imported() -> None:
    code = 'import sys, floor_localizer.commands.locate; sys.exit("rclpy" in sys.modules)'
    assert subprocess.run([sys.executable, '-c', code], check=False).returncode == 0
