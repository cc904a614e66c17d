import math
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from floor_localizer.commands.calibrate_camera import main, save_intrinsics
from floor_localizer.core.dots import DotMap
from floor_localizer.core.mat.page_layout import MatSettings, generate_mat
from floor_localizer.files.dot_map_file import save_csv
from scene_simulator.floor.camera import FloorCamera
from scene_simulator.floor.dot_floor import DotFloor, FloorDesign, FloorMarks
from shirube_core.geometry import SE2, CameraMount, PinholeCamera, matrix_from_rpy
from shirube_ros.camera.files import load_calibration

CAMERA = PinholeCamera(320, 240, 330.0, 331.0, 158.0, 121.0, (-0.2, 0.05, 0.0005, -0.0003, 0.0))
PLAIN = PinholeCamera(320, 240, 330.0, 330.0, 159.5, 119.5)
ROBOT = SE2(0.11, 0.12, 0.7)
SQUARE = MatSettings(width=0.25, height=0.25)


@pytest.fixture(scope='module')
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The map of a mat, the calibration, and the map of another mat."""
    place = tmp_path_factory.mktemp('mat')
    for seed in (1, 2):
        save_csv(place / f'mat{seed}.csv', generate_mat(SQUARE, seed).dot_map)
    save_intrinsics(place / 'camera.yaml', CAMERA)
    return place


def printed_mat() -> DotFloor:
    """The mat on paper, whose dots are round: polygons of 48 corners of the same area."""
    mat = generate_mat(SQUARE, 1)
    angles = np.arange(48) * math.tau / 48
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    circle *= 0.5 * mat.settings.diameter * math.sqrt(math.pi / (24 * math.sin(math.tau / 48)))
    count = len(mat.points)
    outlines = np.broadcast_to(circle, (count, 48, 2)).copy()
    marks = FloorMarks(mat.points, outlines, np.full((count, 3), 0.05), np.ones(count))
    design = FloorDesign(size=(0.25, 0.25), count=count, ground=(0.85, 0.85, 0.85), mottling=0.0)
    return DotFloor(design, marks, np.full(count, mat.settings.diameter))


def photograph(path: Path, mount: CameraMount, camera: PinholeCamera = CAMERA) -> Path:
    rng = np.random.default_rng(3)
    image = FloorCamera(camera).photograph(printed_mat(), [ROBOT], mount, rng=rng).image
    cv2.imwrite(str(path), image)
    return path


def saved(path: Path) -> CameraMount:
    parameters = yaml.safe_load(path.read_text())['/**']['ros__parameters']
    return CameraMount(tuple(parameters['camera_xyz']), tuple(parameters['camera_rpy']))


def angle_between(first: CameraMount, second: CameraMount) -> float:
    cosine = 0.5 * (np.trace(first.rotation.T @ second.rotation) - 1.0)
    return math.degrees(math.acos(min(cosine, 1.0)))


@pytest.mark.parametrize('mount', [
    CameraMount((0.0, 0.0, 0.13)),
    CameraMount((0.02, -0.01, 0.11), (math.pi + 0.05, 0.03, -1.3)),
    CameraMount((0.0, 0.01, 0.16), (math.pi - 0.2, 0.1, -math.pi / 2)),
])  # fmt: skip
def test_the_whole_mount_is_found(folder, tmp_path, run, mount):
    image = photograph(tmp_path / 'image.png', mount)
    where = ('--robot-at', ROBOT.x, ROBOT.y, ROBOT.yaw)
    files = ('--mat', folder / 'mat1.csv', '--image', image, '--calibration', folder / 'camera.yaml')
    code, out, err = run(main, *files, *where, '--out', tmp_path / 'found.yaml')
    assert code == 0, err
    found = saved(tmp_path / 'found.yaml')
    np.testing.assert_allclose(found.xyz, mount.xyz, atol=0.0005)
    assert angle_between(found, mount) < 0.2
    assert 'tilt' in out


def test_without_the_robots_pose_height_and_tilt_are_found_and_the_rest_is_kept(folder, tmp_path, run):
    truth = CameraMount((0.04, 0.01, 0.12), (math.pi + 0.04, 0.02, -math.pi / 2))
    image = photograph(tmp_path / 'image.png', truth)
    files = ('--mat', folder / 'mat1.csv', '--image', image, '--calibration', folder / 'camera.yaml')
    code, out, _ = run(main, *files, '--camera-xyz', 0.04, 0.01, 0.2, '--out', tmp_path / 'found.yaml')
    assert code == 0
    found = saved(tmp_path / 'found.yaml')
    np.testing.assert_allclose(found.xyz, truth.xyz, atol=0.0005)
    assert angle_between(found, truth) < 0.3
    assert 'not observable in one image' in out


def test_the_focal_length_is_found_from_the_height(folder, tmp_path, run):
    image = photograph(tmp_path / 'image.png', CameraMount(), PLAIN)
    files = ('--mat', folder / 'mat1.csv', '--image', image)
    code, out, err = run(main, *files, '--height', 0.13, '--out', tmp_path / 'found.yaml')
    assert code == 0, err
    camera = load_calibration(tmp_path / 'found_intrinsics.yaml')
    assert abs(camera.fx / PLAIN.fx - 1.0) < 0.02
    assert abs(saved(tmp_path / 'found.yaml').xyz[2] - 0.13) < 0.003
    assert f'{130.0 / 330.0:.2f}' in next(line for line in out.splitlines() if line.startswith('pixel'))


def test_the_covariance_is_consistent(folder, tmp_path, run):
    """The rotation matrix of the fit and the one of the simulator are one and the same."""
    mount = CameraMount((0.0, 0.0, 0.13), (math.pi + 0.02, -0.03, -math.pi / 2))
    np.testing.assert_allclose(matrix_from_rpy(mount.rpy), mount.rotation)
    image = photograph(tmp_path / 'image.png', mount)
    files = ('--mat', folder / 'mat1.csv', '--image', image, '--calibration', folder / 'camera.yaml')
    _, out, _ = run(main, *files, '--out', tmp_path / 'found.yaml')
    height = next(line for line in out.splitlines() if line.startswith('height')).split()
    assert abs(float(height[1]) - 130.0) < 5.0 * float(height[4])


@pytest.fixture(scope='module')
def pictures(folder: Path) -> Path:
    """Good and bad pictures, and a map without diameters."""
    image = cv2.imread(str(photograph(folder / 'image.png', CameraMount())), cv2.IMREAD_GRAYSCALE)
    photograph(folder / 'plain.png', CameraMount(), PLAIN)
    half = np.where(np.arange(320) < 110, image, 200)
    for name, other in (('blank', np.full_like(image, 200)), ('small', image[:100, :100]), ('half', half)):
        cv2.imwrite(str(folder / f'{name}.png'), other)
    points = generate_mat(SQUARE, 1).points
    save_csv(folder / 'bare.csv', DotMap(points, np.full(len(points), np.nan)))
    return folder


@pytest.mark.parametrize(('arguments', 'part'), [
    ('--image plain.png', 'focal length and height are not both observable'),
    ('--image plain.png --height -1', '--height: -1 m is not above the floor'),
    ('--image blank.png --calibration camera.yaml', 'shows 0 dots'),
    ('--image image.png --calibration camera.yaml --mat mat2.csv', 'do not match the mat'),
    ('--image half.png --calibration camera.yaml', 'put the mat under the whole view'),
    ('--image none.png --calibration camera.yaml', 'none.png: cannot be read'),
    ('--image small.png --calibration camera.yaml', 'the calibration is for 320 x 240 px'),
    ('--image image.png --calibration camera.yaml --mat bare.csv', 'without a diameter'),
    ('--image image.png --calibration camera.yaml --out mat1.csv/x.yaml', 'choose a writable place'),
])  # fmt: skip
@pytest.mark.newest_set_only
@pytest.mark.filterwarnings('error::RuntimeWarning')
def test_bad_input_is_one_line_and_exit_code_1(pictures, refusal, monkeypatch, arguments, part):
    monkeypatch.chdir(pictures)
    line = refusal(main, '--mat', 'mat1.csv', '--out', 'found.yaml', *arguments.split())
    assert part in line
    assert '± inf' not in line
    assert '± nan' not in line
    assert not Path('found.yaml').exists()
