"""Calibration of an L of three cameras against the true one, and the files that the command writes."""

from functools import cache

import cv2
import numpy as np
import pytest
import yaml

from reward_planner.commands.calibrate_rig import main as calibrate_rig_command
from reward_planner.core.depth.rig_calibration import CalibratedCamera, calibrate_rig, misalignment, rectify_rig
from reward_planner.core.depth.stereo_pair import pair_from_projections
from reward_planner.core.depth.trinocular_depth import points_from_depth_image
from reward_planner.core.reward_planner_error import RewardPlannerError
from shirube_core.geometry import PinholeCamera, matrix_from_rpy
from shirube_ros.camera.files import load_calibration

SIZE = (320, 240)
CAMERAS = (
    PinholeCamera(*SIZE, 262.0, 261.0, 160.2, 118.0, (-0.28, 0.08, 0.0004, -0.0003, 0.0)),
    PinholeCamera(*SIZE, 259.0, 259.5, 157.5, 121.3, (-0.26, 0.07, -0.0005, 0.0002, 0.0)),
    PinholeCamera(*SIZE, 264.5, 264.0, 161.9, 120.8, (-0.29, 0.09, 0.0002, 0.0004, 0.0)),
)
CENTRES = tuple(np.array(c) for c in ((0.0, 0.0, 0.0), (0.1, 0.0015, -0.002), (0.003, -0.11, 0.001)))
ROTATIONS = tuple(matrix_from_rpy(np.radians(rpy)) for rpy in ((0, 0, 0), (0.6, -1.1, 0.8), (-0.9, 0.7, -0.5)))
"""As mounted by hand: neither parallel nor right-angled."""
COLUMNS, ROWS, SQUARE = 9, 6, 0.03
BOARD = SQUARE * np.stack(np.meshgrid(np.arange(COLUMNS), np.arange(ROWS)), axis=-1).reshape(-1, 2)


def project(points, noise=0.0, rng=None):
    """Pixels of points in the left camera's frame, shape (n, 3), in the three raw images."""
    pixels = [
        camera.pixels_from_points((points - centre) @ rotation)
        for camera, rotation, centre in zip(CAMERAS, ROTATIONS, CENTRES, strict=True)
    ]
    return [each + (rng.normal(0.0, noise, each.shape) if noise else 0.0) for each in pixels]


def board_poses(count):
    """Rotation and corner of the board, tilted and at several distances."""
    rng = np.random.default_rng(3)
    middle = np.array([*(0.5 * SQUARE * np.array([COLUMNS - 1, ROWS - 1])), 0.0])
    for _ in range(count):
        R = matrix_from_rpy(rng.uniform(-0.6, 0.6, 3) * (1.0, 1.0, 0.5))
        distance = rng.uniform(0.4, 0.8)
        place = distance * np.array([*rng.uniform(-0.25, 0.25, 2), 1.0])
        yield R, place - R @ middle


def views_of(count, noise):
    rng = np.random.default_rng(4)
    corners = np.column_stack([BOARD, np.zeros(len(BOARD))])
    return [project(corners @ R.T + t, noise, rng) for R, t in board_poses(count)]


def scene_points():
    rng = np.random.default_rng(5)
    z = rng.uniform(0.6, 5.0, 500)
    return np.column_stack([rng.uniform(-0.4, 0.4, 500) * z, rng.uniform(-0.3, 0.3, 500) * z, z])


def check_alignment(cameras, limit, depth_limit):
    """Rows and columns agree, and eq. (2) gives the depth along the rectified axis."""
    points = scene_points()
    raw = project(points)
    left, right, top = (camera.rectify_pixels(each) for camera, each in zip(cameras, raw, strict=True))
    assert np.abs(left[:, 1] - right[:, 1]).max() < limit
    assert np.abs(left[:, 0] - top[:, 0]).max() < limit
    P = [camera.projection for camera in cameras]
    depth = points @ cameras[0].rotation[2]
    for axis, other, pixels in ((0, P[1], right), (1, P[2], top)):
        pair = pair_from_projections(P[0], other)
        assert pair.axis == axis
        disparity = pair.sign * (left[:, axis] - pixels[:, axis])
        assert np.abs(pair.focal_baseline / disparity / depth - 1.0)[depth < 2.0].max() < depth_limit


def test_the_rectification_of_a_known_rig_is_exact():
    cameras = rectify_rig(CAMERAS, ROTATIONS, CENTRES)
    check_alignment(cameras, 1e-5, 1e-6)
    # The sheared pixels of a depth image lead back to the points.
    P, depth = cameras[0].projection, np.full(SIZE[::-1], 2.0, dtype=np.float32)
    rectified = PinholeCamera(*SIZE, P[0, 0], P[1, 1], P[0, 2], P[1, 2])
    points = points_from_depth_image(depth, rectified, P[0, 1]) @ P[:, :3].T
    v, u = np.mgrid[0.0 : SIZE[1], 0.0 : SIZE[0]]
    assert np.abs(points[:, :2] / points[:, 2:] - np.column_stack([u.ravel(), v.ravel()])).max() < 1e-3
    # All of them are in the raw images.
    for camera in cameras:
        rays = points[:, :3] @ np.linalg.inv(P[:, :3]).T @ camera.rotation
        raw = camera.camera.pixels_from_points(rays)
        assert ((raw > -0.01) & (raw < np.array(SIZE) - 0.99)).all()


def test_a_rig_calibrated_from_noisy_corners_agrees_to_a_tenth_of_a_pixel():
    found = calibrate_rig(BOARD, views_of(12, 0.05), SIZE)
    check_alignment(found, 0.1, 0.01)
    assert max(misalignment(found, project(scene_points()))) < 0.05


def turned(angle):
    """The right camera turned about y."""
    return (np.eye(3), matrix_from_rpy((0.0, angle, 0.0)), np.eye(3))


@pytest.mark.parametrize(
    ('centres', 'rotations', 'words'),
    [
        ((CENTRES[0], CENTRES[2], CENTRES[1]), ROTATIONS, 'not in an L'),
        ((CENTRES[0], CENTRES[1], CENTRES[1]), ROTATIONS, 'not in an L'),
        (CENTRES, turned(1.5), 'parallel'),
    ],
)
def test_what_is_no_l_is_refused(centres, rotations, words):
    with pytest.raises(RewardPlannerError, match=words):
        rectify_rig(CAMERAS, rotations, centres)


@cache
def raw_rays(camera):
    """Rays of all pixels."""
    v, u = np.mgrid[0.0 : SIZE[1], 0.0 : SIZE[0]]
    return camera.rays_from_pixels(np.column_stack([u.ravel(), v.ravel()]))


def render_board(R, t):
    """The raw images of the board, by warping a picture of it; lenses distort as in `CAMERAS`."""
    picture = np.full(((ROWS + 3) * 40, (COLUMNS + 3) * 40), 255, dtype=np.uint8)
    for i, j in np.argwhere(np.add.outer(np.arange(ROWS + 1), np.arange(COLUMNS + 1)) % 2 == 0):
        picture[40 * (i + 1) : 40 * (i + 2), 40 * (j + 1) : 40 * (j + 2)] = 0
    for camera, rotation, centre in zip(CAMERAS, ROTATIONS, CENTRES, strict=True):
        rays = raw_rays(camera) @ rotation.T @ R
        origin = (centre - t) @ R
        hits = origin[:2] - rays[:, :2] * (origin[2] / rays[:, 2:])
        x, y = (40.0 * (hits / SQUARE + 2.0) - 0.5).T.reshape(2, *SIZE[::-1]).astype(np.float32)
        image = cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=128)
        yield cv2.GaussianBlur(image, (0, 0), 0.7)


@pytest.fixture(scope='module')
def images(tmp_path_factory):
    folder = tmp_path_factory.mktemp('rig')
    for k, pose in enumerate(board_poses(9)):
        for name, image in zip(('left', 'right', 'top'), render_board(*pose), strict=True):
            (folder / name).mkdir(exist_ok=True)
            cv2.imwrite(str(folder / name / f'{k:02}.png'), image)
    return folder


def test_the_command_writes_calibrations_of_a_common_rectification(images, tmp_path, capsys):
    assert calibrate_rig_command([str(images), '--square', str(SQUARE), '--out', str(tmp_path)]) == 0
    assert 'baselines 0.100' in capsys.readouterr().out
    files = [yaml.safe_load((tmp_path / f'{name}.yaml').read_text()) for name in ('left', 'right', 'top')]
    cameras = []
    for name, file in zip(('left', 'right', 'top'), files, strict=True):
        R, P = (np.reshape(file[f'{key}_matrix']['data'], (3, -1)) for key in ('rectification', 'projection'))
        cameras.append(CalibratedCamera(load_calibration(tmp_path / f'{name}.yaml'), R, P))
    check_alignment(cameras, 0.3, 0.02)
    assert np.abs([each.projection[k, 3] for each, k in zip(cameras, (1, 1, 0), strict=True)]).max() < 1e-9


@pytest.mark.parametrize(
    ('kept', 'options', 'words'),
    [
        ((2, 2, 2), [], 'at least 5'),
        ((2, 1, 2), [], 'numbers of images differ (left 2, right 1, top 2)'),
        ((2, 2, 2), ['--square', '-1'], '--square in metres'),
        ((2, 2, 0), [], 'has no images'),
    ],
)
def test_what_cannot_be_calibrated_is_reported_in_one_line(images, tmp_path, kept, options, words, capsys):
    for name, count in zip(('left', 'right', 'top'), kept, strict=True):
        (tmp_path / name).mkdir()
        for file in sorted((images / name).iterdir())[:count]:
            (tmp_path / name / file.name).write_bytes(file.read_bytes())
    assert calibrate_rig_command([str(tmp_path), '--square', str(SQUARE), *options]) == 1
    said = capsys.readouterr().err
    assert words in said
    assert said.startswith('calibrate_rig: ')
    assert said.count('\n') == 1
