import errno
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from simulated_survey import lane_poses

from floor_localizer.commands.build_map import main
from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.survey.map_comparison import compare
from floor_localizer.files.camera_files import save_intrinsics
from floor_localizer.files.csv_form import load_csv, save_csv
from floor_localizer.survey_files import checkpoint
from scene_simulator.dot_floor import FloorDesign, lay_floor
from scene_simulator.floor_camera import PAPER_CAMERA, FloorCamera
from scene_simulator.scene_messages import camera_info, compressed_image, odometry
from shirube_bags.bag_writer import BagWriter
from shirube_geometry import CameraMount, PlanarPose

SIZE = (0.4, 0.25)
MOUNT = CameraMount((0.05, -0.02, 0.13))
FLAGS = ('--camera-xyz', '0.05', '-0.02', '0.13')
START_NS, STEP_NS = 1_700_000_000_000_000_000, 100_000_000


@pytest.fixture(scope='module')
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of images with their odometry, a bag of the same, and the true map."""
    folder = tmp_path_factory.mktemp('drive')
    floor = lay_floor(FloorDesign(size=SIZE, count=round(5384 * SIZE[0] * SIZE[1])), seed=1)
    save_csv(folder / 'true.csv', DotMap(floor.points, floor.diameters))
    save_intrinsics(folder / 'camera.yaml', PAPER_CAMERA)
    truth, rng, camera = lane_poses(SIZE), np.random.default_rng(1), FloorCamera()
    odometry_poses = rough(truth)
    (folder / 'images').mkdir()
    rows = ['image,x,y,yaw']
    with BagWriter(folder / 'bag') as bag:
        for k, (pose, rough_pose) in enumerate(zip(truth, odometry_poses)):
            image = camera.photograph(floor, [pose], MOUNT, rng=rng).image
            cv2.imwrite(str(folder / 'images' / f'{k:03d}.png'), image)
            rows.append(f'{k:03d}.png,{rough_pose.x:.6f},{rough_pose.y:.6f},{rough_pose.yaw:.6f}')
            stamp = START_NS + k * STEP_NS
            bag.write(
                '/camera_info',
                'sensor_msgs/msg/CameraInfo',
                camera_info(PAPER_CAMERA, 'camera', stamp),
                stamp,
            )
            bag.write('/odom', 'nav_msgs/msg/Odometry', odometry(rough_pose, (0.2, 0.0), stamp), stamp)
            message = compressed_image(image, 'camera', stamp)
            bag.write('/image_raw/compressed', 'sensor_msgs/msg/CompressedImage', message, stamp)
    (folder / 'odom.csv').write_text('\n'.join([*rows, '']))
    return folder


def rough(truth: list[PlanarPose]) -> list[PlanarPose]:
    """2 % too far, and a heading that drifts by 1 degree a metre."""
    found = [PlanarPose(0.0, 0.0, 0.0)]
    for before, after in zip(truth, truth[1:]):
        step = before.inverse() @ after
        way = math.hypot(step.x, step.y)
        found.append(found[-1] @ PlanarPose(1.02 * step.x, 1.02 * step.y, step.yaw + 0.0175 * way))
    return found


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    capsys.readouterr()
    code = main([*map(str, arguments), *FLAGS])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def folder_options(scene: Path) -> list[object]:
    return [
        '--images',
        scene / 'images',
        '--calibration',
        scene / 'camera.yaml',
        '--odometry',
        scene / 'odom.csv',
    ]


def fault_of(err: str) -> str:
    lines = [line for line in err.splitlines() if line.startswith('build_map: ')]
    assert len(lines) == 1, err
    return lines[0]


@pytest.mark.parametrize('source', ['folder', 'bag'])
def test_a_drive_becomes_a_map(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], source: str
) -> None:
    given = folder_options(scene) if source == 'folder' else ['--bag', scene / 'bag']
    code, out, err = run(capsys, *given, '--out', tmp_path)
    assert code == 0, err
    found = compare(load_csv(scene / 'true.csv'), load_csv(tmp_path / 'map.csv'))
    assert np.percentile(np.hypot(*found.residuals.T), 90.0) < 0.0002
    assert len(found.extra) <= 3
    assert len(found.missing) < 0.08 * len(found.pairs)
    assert 'loops' in out
    assert (tmp_path / 'report.txt').read_text().strip() in out
    assert (tmp_path / 'sightings.csv').read_text().startswith('x,y,diameter,count\n')
    for name in ('map.png', 'residuals.png'):
        assert cv2.imread(str(tmp_path / name)) is not None


def test_a_known_length_sets_the_scale(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # A camera that is believed to hang 1 % too high makes a map that is 1 % too large.
    wrong = [
        '--images',
        scene / 'images',
        '--calibration',
        scene / 'camera.yaml',
        '--odometry',
        scene / 'odom.csv',
    ]
    high = ('--camera-xyz', '0.05', '-0.02', '0.1313')
    assert main([*map(str, wrong), '--out', str(tmp_path / 'a'), *high]) == 0
    truth, found = load_csv(scene / 'true.csv'), load_csv(tmp_path / 'a' / 'map.csv')
    before = compare(truth, found)
    assert 1.007 < before.scale < 1.013
    # The farthest two common dots, measured to a tenth of a millimetre.
    ends = before.pairs[
        [
            np.argmin(truth.points[before.pairs[:, 0]].sum(1)),
            np.argmax(truth.points[before.pairs[:, 0]].sum(1)),
        ]
    ]
    length = float(np.hypot(*np.diff(truth.points[ends[:, 0]], axis=0)[0])) + 0.0001
    places = found.points[ends[:, 1]].ravel()
    known = ['--known-length', *places, length]
    assert main([*map(str, wrong), '--out', str(tmp_path / 'a'), *high, *map(str, known)]) == 0
    after = compare(truth, load_csv(tmp_path / 'a' / 'map.csv'))
    assert abs(after.scale - 1.0) < 0.0008
    code, _, err = run(
        capsys, *folder_options(scene), '--out', tmp_path / 'b', '--known-length', *places, 2 * length
    )
    assert code == 1
    assert 'check which dots were measured' in fault_of(err)


def test_a_second_drive_extends_the_map(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = load_csv(scene / 'true.csv')
    left = truth.points[:, 0] < 0.2
    save_csv(tmp_path / 'left.csv', DotMap(truth.points[left], truth.diameters[left]))
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path, '--extend', tmp_path / 'left.csv')
    assert code == 0, err
    found = load_csv(tmp_path / 'map.csv')
    np.testing.assert_allclose(found.points[: left.sum()], truth.points[left], atol=1e-6)
    assert len(found) > 1.5 * left.sum()


def test_a_full_disk_is_told_and_the_survey_goes_on(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    saved = np.savez
    calls = []

    def full(file: object, **arrays: object) -> None:
        calls.append(1)
        if len(calls) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        saved(file, **arrays)

    monkeypatch.setattr(checkpoint.np, 'savez', full)
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path)
    assert code == 1
    assert 'No space left on device; free some and give the same command again' in fault_of(err)
    assert [path.name for path in (tmp_path / 'checkpoint').iterdir() if path.name.startswith('.')] == []
    monkeypatch.setattr('floor_localizer.survey_files.survey_run.DotDetector', forbidden)
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path)
    assert code == 0, err  # the dots were kept: no image was looked at again


def forbidden() -> SimpleNamespace:
    def detect(_: object) -> None:
        raise AssertionError('an image is looked at again')

    return SimpleNamespace(detect=detect)


def test_a_killed_survey_goes_on_and_ends_the_same(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(capsys, *folder_options(scene), '--out', tmp_path / 'whole')[0] == 0
    command = [sys.executable, '-m', 'floor_localizer.commands.build_map', *map(str, folder_options(scene))]
    child = subprocess.Popen(
        [*command, '--out', str(tmp_path / 'killed'), *FLAGS],
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    deadline = time.monotonic() + 90.0
    while (
        not (tmp_path / 'killed' / 'checkpoint' / 'dots_00000.npz').exists() and time.monotonic() < deadline
    ):
        time.sleep(0.01)
    child.send_signal(signal.SIGKILL)
    child.wait()
    assert not (tmp_path / 'killed' / 'map.csv').exists()
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path / 'killed')
    assert code == 0, err
    assert (tmp_path / 'killed' / 'map.csv').read_bytes() == (tmp_path / 'whole' / 'map.csv').read_bytes()


def test_images_that_cannot_be_used_are_told_and_left_out(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    images = tmp_path / 'images'
    images.mkdir()
    for path in (scene / 'images').iterdir():
        (images / path.name).write_bytes(path.read_bytes())
    cv2.imwrite(str(images / '005.png'), np.full((100, 120), 200, dtype=np.uint8))
    (images / '009.png').write_bytes((images / '009.png').read_bytes()[:500])
    cv2.imwrite(str(images / '012.png'), np.full((235, 235), 200, dtype=np.uint8))
    given = ['--images', images, '--calibration', scene / 'camera.yaml', '--odometry', scene / 'odom.csv']
    code, out, err = run(capsys, *given, '--out', tmp_path / 'out')
    assert code == 0, err
    assert '005.png: is 120 x 100 px, the calibration is for 235 x 235 px' in out
    assert '009.png: is truncated' in out
    assert '012.png: shows 0 dots' in out
    found = compare(load_csv(scene / 'true.csv'), load_csv(tmp_path / 'out' / 'map.csv'))
    assert np.percentile(np.hypot(*found.residuals.T), 90.0) < 0.0004


def changed_csv(scene: Path, folder: Path, change: str) -> Path:
    lines = (scene / 'odom.csv').read_text().splitlines()
    if change == 'missing':
        del lines[7]
    elif change == 'words':
        lines[7] = '006.png,a,b,c'
    elif change == 'header':
        lines[0] = 'x,y,yaw'
    (folder / f'{change}.csv').write_text('\n'.join(lines))
    return folder / f'{change}.csv'


@pytest.mark.parametrize(
    ('change', 'part'),
    [
        ('missing', 'odometry is missing for 006.png'),
        ('words', 'line 8: is no name and three numbers'),
        ('header', 'line 1: the header must be "image,x,y,yaw"'),
    ],
)
def test_bad_odometry_is_one_line(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], change: str, part: str
) -> None:
    given = folder_options(scene)[:-1]
    code, _, err = run(capsys, *given, changed_csv(scene, tmp_path, change), '--out', tmp_path / 'out')
    assert code == 1
    assert part in fault_of(err)


@pytest.mark.parametrize(
    ('stamps', 'part'),
    [
        ([], 'has no odometry'),
        ([0, 1, 2, 1, 3], '/odom: its stamps run backwards 0.200 s after the first'),
        ([0, 1], '/odom: odometry is missing around image'),
    ],
)
def test_a_bag_with_bad_odometry_is_one_line(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], stamps: list[int], part: str
) -> None:
    image = cv2.imread(str(scene / 'images' / '000.png'), cv2.IMREAD_GRAYSCALE)
    with BagWriter(tmp_path / 'bag') as bag:
        for k in range(8):
            stamp = START_NS + k * STEP_NS
            bag.write(
                '/camera_info',
                'sensor_msgs/msg/CameraInfo',
                camera_info(PAPER_CAMERA, 'camera', stamp),
                stamp,
            )
            bag.write(
                '/image_raw/compressed',
                'sensor_msgs/msg/CompressedImage',
                compressed_image(image, 'camera', stamp),
                stamp,
            )
        for number, k in enumerate(stamps):
            message = odometry(PlanarPose(0.1 * k, 0.0, 0.0), (0.2, 0.0), START_NS + k * STEP_NS)
            bag.write('/odom', 'nav_msgs/msg/Odometry', message, START_NS + number * STEP_NS)
    code, _, err = run(capsys, '--bag', tmp_path / 'bag', '--out', tmp_path / 'out')
    assert code == 1
    assert part in fault_of(err)


def test_a_drive_whose_images_do_not_overlap_is_one_line(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'images').mkdir()
    rows, poses = ['image,x,y,yaw'], (scene / 'odom.csv').read_text().splitlines()[1:]
    for k in range(0, 20, 4):
        name = f'{k:03d}.png'
        (tmp_path / 'images' / name).write_bytes((scene / 'images' / name).read_bytes())
        rows.append(poses[k])
    (tmp_path / 'odom.csv').write_text('\n'.join(rows))
    given = [
        '--images',
        tmp_path / 'images',
        '--calibration',
        scene / 'camera.yaml',
        '--odometry',
        tmp_path / 'odom.csv',
    ]
    code, _, err = run(capsys, *given, '--out', tmp_path / 'out')
    assert code == 1
    assert 'no overlap: only' in fault_of(err)


@pytest.mark.parametrize(
    ('arguments', 'part'),
    [
        ('--images {0}/images --odometry {0}/odom.csv', '--calibration is missing'),
        ('--images {0}/images --calibration {0}/camera.yaml', '--odometry is missing'),
        ('--images {0}/none --calibration {0}/camera.yaml --odometry {0}/odom.csv', 'none: does not exist'),
        ('--bag {0}/none', 'none: does not exist'),
        ('--bag {0}/bag --out {0}/odom.csv/x', 'choose a writable place'),
        ('--bag {0}/bag --camera-rpy 0 0 0', 'camera_rpy'),
        ('--bag {0}/bag --extend {0}/none.csv', 'none.csv: cannot be read'),
        ('--bag {0}/bag --extend {0}/true.csv --known-length 0 0 1 0 1', 'give one of both'),
        ('--bag {0}/bag --image-step 2', 'image_step is 2'),
    ],
)
def test_bad_input_is_one_line_and_exit_code_1(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: str, part: str
) -> None:
    given = arguments.format(scene).split()
    if '--out' not in given:
        given += ['--out', str(tmp_path)]
    code, _, err = run(capsys, *given)
    assert code == 1
    assert part in fault_of(err)


def test_checkpoints_of_another_survey_are_not_mixed_in(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(capsys, *folder_options(scene), '--out', tmp_path)[0] == 0
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path, '--image-step', 0.5)
    assert code == 1
    assert 'belongs to a survey with other images or options' in fault_of(err)
