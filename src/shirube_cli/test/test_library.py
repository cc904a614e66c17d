"""The library gives what recordings know to be true, and one line for what it cannot use."""

import math
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

import shirube
from shirube_bags.bag_reader import BagReader
from shirube_cli.project import find_home
from shirube_core.geometry import PinholeCamera
from shirube_ros.camera.info import camera_from_camera_info

BAGS = find_home() / 'bags'
CAMERA = shirube.Camera(4, 3, 2.0, 2.0, 2.0, 1.5)


def recorded(bag: Path, prefix: str = '', count: int = 1) -> tuple[list[np.ndarray], PinholeCamera]:
    with BagReader(bag) as reader:
        info = reader.decode(next(reader.messages([f'{prefix}/camera_info'])))
        topic = next(name for name in reader.topics if name.startswith(f'{prefix}/image') and 'compressed' in name)
        messages = [m for m, _ in zip(reader.messages([topic]), range(count))]
        images = [cv2.imdecode(reader.decode(m).data, cv2.IMREAD_GRAYSCALE) for m in messages]
    return images, camera_from_camera_info(info, 'camera_info')


def true_pose(bag: Path, number: int = 0) -> tuple[float, float, float]:
    with BagReader(bag) as reader:
        pose = reader.decode(list(reader.messages(['/ground_truth']))[number]).pose
    q = pose.orientation
    return pose.position.x, pose.position.y, 2.0 * math.atan2(q.z, q.w)


def test_floor_image_as_a_list_has_the_true_pose_and_half_of_it_is_refused() -> None:
    (image,), camera = recorded(BAGS / 'floor_drive')
    localizer = shirube.floor.Localizer()
    result = localizer.locate(image.tolist(), camera)
    assert result
    assert result.pose == pytest.approx(true_pose(BAGS / 'floor_drive'), abs=1e-3)
    assert np.linalg.eigvalsh(result.covariance).min() > 0.0
    assert localizer.locate(np.zeros_like(image), camera).reason.startswith('no dots')
    with pytest.raises(shirube.InputError, match=r'117 x 117 px, its camera is calibrated for 235 x 235 px; '):
        localizer.locate(image[:117, :117], camera)


def test_lamps_give_the_true_pose_and_their_ids_need_no_list() -> None:
    bag = BAGS / 'lamp_drive'
    images, camera = recorded(bag, count=120)
    result = shirube.lamps.read(images, camera, bag / 'beacons.yaml')
    assert result.pose == pytest.approx(true_pose(bag, 119), abs=0.03)
    alone = shirube.lamps.read(images, camera)
    assert alone.reason == 'no known lamp in view'
    assert set(alone.lamps) == set(result.lamps) == {1, 2, 3, 4}


def test_route_is_shortest_and_keeps_the_radius() -> None:
    grid = [[0] * 9 for _ in range(9)]
    assert shirube.plan(grid, (0, 0), (8, 8)).length == pytest.approx(8 * math.sqrt(2.0))
    for row in range(7):
        grid[row][4] = 100
    around = shirube.plan(grid, (0, 0), (0, 8), robot_radius=1.0)
    assert min(math.hypot(r - 6, c - 4) for r, c in around.cells if r > 6) > 1.0
    assert shirube.plan(grid, (0, 0), (0, 8), robot_radius=2.0).reason == 'obstacles block every path'


def test_fused_pose_follows_the_sources_that_agree_with_odometry() -> None:
    drive = [(0.1 * k, 0.05 * k, 0.0, 0.0) for k in range(40)]
    fused = shirube.fuse({'floor': drive}, drive, sigmas={'floor': (0.01, 0.01)})
    assert fused.pose == pytest.approx((1.95, 0.0, 0.0), abs=1e-6)
    assert sum(fused.counts['floor'].values()) == len(drive)
    assert shirube.fuse({'floor': []}, drive).reason == 'no source has a pose'


@pytest.mark.parametrize(
    ('call', 'said'),
    [
        (lambda: shirube.plan([[0, 1], [2]], (0, 0), (1, 1)), 'rows of equal length'),
        (lambda: shirube.plan([[0, 500]], (0, 0), (0, 1)), 'per cent'),
        (lambda: shirube.fuse({'floor': [(1.0, 2.0)]}), 'n x 4 numbers'),
        (lambda: shirube.fuse({'floor': [(0, math.nan, 0, 0)]}), 'not finite'),
        (lambda: shirube.floor.Localizer(map=[[1.0, 2.0, 3.0]]), 'n x 2 numbers'),
        (lambda: shirube.floor.Localizer(camera_xyz=3), '3 numbers'),
        (lambda: shirube.lamps.read([], CAMERA), 'no images'),
        (lambda: shirube.lamps.read([[[0.5] * 4] * 3], CAMERA), 'whole numbers'),
        (lambda: shirube.lamps.read([[[0]]], 7), 'shirube.Camera'),
    ],
)
def test_bad_input_is_one_line_with_the_remedy(call: Callable[[], object], said: str) -> None:
    with pytest.raises(shirube.InputError, match=said) as caught:
        call()
    assert '\n' not in str(caught.value)
    assert '; ' in str(caught.value)
