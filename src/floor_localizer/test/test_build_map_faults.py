import os
from pathlib import Path

import cv2
import pytest
from survey_scene import START_NS, STEP_NS, fault_of, folder_options, record_drive, run

from floor_localizer.core.independent_tasks import InProcessRunner
from scene_simulator.floor.camera import PAPER_CAMERA
from scene_simulator.messages import camera_info, compressed_image, odometry
from shirube_bags.bag_writer import BagWriter
from shirube_core.files import exclusive_lock
from shirube_core.geometry import SE2


@pytest.fixture(scope='module')
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record_drive(tmp_path_factory.mktemp('drive'))


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
        ('words', 'line 8: is not a name and three numbers'),
        ('header', 'line 1: the header must be "image,x,y,yaw"'),
    ],
)
def test_bad_odometry_is_one_line(scene, tmp_path, capsys, change, part):
    given = folder_options(scene, odometry=changed_csv(scene, tmp_path, change))
    code, _, err = run(capsys, *given, '--out', tmp_path / 'out')
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
def test_a_bag_with_bad_odometry_is_one_line(scene, tmp_path, capsys, stamps, part):
    image = cv2.imread(str(scene / 'images' / '000.png'), cv2.IMREAD_GRAYSCALE)
    with BagWriter(tmp_path / 'bag') as bag:
        for k in range(8):
            stamp = START_NS + k * STEP_NS
            info = camera_info(PAPER_CAMERA, 'camera', stamp)
            bag.write('/camera_info', 'sensor_msgs/msg/CameraInfo', info, stamp)
            picture = compressed_image(image, 'camera', stamp)
            bag.write('/image_raw/compressed', 'sensor_msgs/msg/CompressedImage', picture, stamp)
        for number, k in enumerate(stamps):
            message = odometry(SE2(0.1 * k, 0.0, 0.0), (0.2, 0.0), START_NS + k * STEP_NS)
            bag.write('/odom', 'nav_msgs/msg/Odometry', message, START_NS + number * STEP_NS)
    code, _, err = run(capsys, '--bag', tmp_path / 'bag', '--out', tmp_path / 'out')
    assert code == 1
    assert part in fault_of(err)


def test_a_drive_whose_images_do_not_overlap_is_one_line(scene, tmp_path, capsys):
    (tmp_path / 'images').mkdir()
    rows, poses = ['image,x,y,yaw'], (scene / 'odom.csv').read_text().splitlines()[1:]
    for k in range(0, 20, 4):
        name = f'{k:03d}.png'
        (tmp_path / 'images' / name).write_bytes((scene / 'images' / name).read_bytes())
        rows.append(poses[k])
    (tmp_path / 'odom.csv').write_text('\n'.join(rows))
    given = folder_options(scene, images=tmp_path / 'images', odometry=tmp_path / 'odom.csv')
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
def test_bad_input_is_one_line_and_exit_code_1(scene, tmp_path, capsys, arguments, part):
    given = arguments.format(scene).split()
    if '--out' not in given:
        given += ['--out', str(tmp_path)]
    code, _, err = run(capsys, *given)
    assert code == 1
    assert part in fault_of(err)


def test_workers_that_write_to_another_folder_are_an_error(scene, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(InProcessRunner, 'run', lambda _, __, arguments: iter([None] * len(arguments)))
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path)
    assert code == 1
    assert 'use workers that see the same files under the same names' in fault_of(err)


def test_an_interrupt_is_one_line(scene, tmp_path, capsys, monkeypatch):
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(InProcessRunner, 'run', interrupted)
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path)
    assert code == 130
    assert 'give the same command again to resume' in fault_of(err)


@pytest.mark.newest_set_only
def test_checkpoints_of_another_survey_are_not_mixed_in(scene, tmp_path, capsys):
    assert run(capsys, *folder_options(scene), '--out', tmp_path)[0] == 0
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path, '--image-step', 0.5)
    assert code == 1
    assert 'another survey, which differs by its settings; remove it' in fault_of(err)
    os.utime(scene / 'images' / '004.png', (1.0, 1.0))  # another image under the same name
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path)
    assert code == 1
    assert 'another survey, which differs by its images; remove it' in fault_of(err)


def test_only_one_survey_runs_in_a_folder(scene, tmp_path, capsys):
    with exclusive_lock(tmp_path / 'checkpoint', file='lock'):
        code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path)
    assert code == 1
    assert 'another survey is running there; wait for its end or choose another --out' in fault_of(err)
