"""A rendered drive as a folder of images and as a bag, and how the command is run on it."""

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from simulated_survey import lane_poses

from floor_localizer.commands.build_map import main
from floor_localizer.commands.calibrate_camera import save_intrinsics
from floor_localizer.core.dots import DotMap
from floor_localizer.files.dot_map_file import save_csv
from scene_simulator.floor.camera import PAPER_CAMERA, FloorCamera
from scene_simulator.floor.dot_floor import FloorDesign, generate_dot_floor
from scene_simulator.messages import camera_info, compressed_image, odometry
from shirube_bags.bag_writer import BagWriter
from shirube_core.geometry import SE2, CameraMount

SIZE = (0.4, 0.25)
MOUNT = CameraMount((0.05, -0.02, 0.13))
FLAGS = ('--camera-xyz', '0.05', '-0.02', '0.13', '--workers', '1')
SMALL_SIZE = (0.3, 0.2)
"""Enough where one survey is compared with another."""
START_NS, STEP_NS = 1_700_000_000_000_000_000, 100_000_000


def record_drive(folder: Path, size: tuple[float, float] = SIZE) -> Path:
    """Write a folder of images with their odometry, a bag of the same, and the true map."""
    floor = generate_dot_floor(FloorDesign(size=size, count=round(5384 * size[0] * size[1])), seed=1)
    save_csv(folder / 'true.csv', DotMap(floor.points, floor.diameters))
    save_intrinsics(folder / 'camera.yaml', PAPER_CAMERA)
    truth, rng, camera = lane_poses(size), np.random.default_rng(1), FloorCamera()
    odometry_poses = rough(truth)
    (folder / 'images').mkdir()
    rows = ['image,x,y,yaw']
    with BagWriter(folder / 'bag') as bag:
        for k, (pose, rough_pose) in enumerate(zip(truth, odometry_poses)):
            image = camera.photograph(floor, [pose], MOUNT, rng=rng).image
            cv2.imwrite(str(folder / 'images' / f'{k:03d}.png'), image)
            rows.append(f'{k:03d}.png,{rough_pose.x:.6f},{rough_pose.y:.6f},{rough_pose.yaw:.6f}')
            stamp = START_NS + k * STEP_NS
            write_image(bag, image, stamp)
            bag.write('/odom', 'nav_msgs/msg/Odometry', odometry(rough_pose, (0.2, 0.0), stamp), stamp)
    (folder / 'odom.csv').write_text('\n'.join([*rows, '']))
    return folder


def write_image(bag: BagWriter, image: NDArray[np.uint8], stamp: int, end: int | None = None) -> None:
    """Write an image, whose data are cut off at ``end``, and its CameraInfo."""
    info, message = camera_info(PAPER_CAMERA, 'camera', stamp), compressed_image(image, 'camera', stamp)
    message.data = message.data[:end]
    bag.write('/camera_info', 'sensor_msgs/msg/CameraInfo', info, stamp)
    bag.write('/image_raw/compressed', 'sensor_msgs/msg/CompressedImage', message, stamp)


def rough(truth: list[SE2]) -> list[SE2]:
    """Return odometry that is 2 % too long and whose yaw drifts by 1 degree per metre."""
    found = [SE2(0.0, 0.0, 0.0)]
    for before, after in zip(truth, truth[1:]):
        step = before.inverse() @ after
        way = math.hypot(step.x, step.y)
        found.append(found[-1] @ SE2(1.02 * step.x, 1.02 * step.y, step.yaw + 0.0175 * way))
    return found


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    capsys.readouterr()
    code = main([*map(str, arguments), *FLAGS])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def folder_options(scene: Path, **other: Path) -> list[object]:
    names = {'images': 'images', 'calibration': 'camera.yaml', 'odometry': 'odom.csv'}
    paths = {option: scene / name for option, name in names.items()} | other
    return [each for option, path in paths.items() for each in (f'--{option}', path)]


def fault_of(err: str) -> str:
    lines = [line for line in err.splitlines() if line.startswith('build_map: ')]
    assert len(lines) == 1, err
    return lines[0]
