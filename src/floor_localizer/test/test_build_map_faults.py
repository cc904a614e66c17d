import os
import shutil
from collections.abc import Callable

import cv2
import pytest
from survey_scene import START_NS, STEP_NS, fault_of, folder_options, run, write_image

from floor_localizer.core.independent_tasks import InProcessRunner
from scene_simulator.messages import odometry
from shirube_bags.bag_writer import BagWriter
from shirube_core.files import exclusive_lock
from shirube_core.geometry import SE2


@pytest.fixture
def fault(capsys) -> Callable[..., str]:
    """Runs the command, which must end with an exit code, and returns its one line."""

    def run_with_fault(*arguments: object, expected: int = 1) -> str:
        code, _, err = run(capsys, *arguments)
        assert code == expected
        return fault_of(err)

    return run_with_fault


def without_image(lines: list[str]) -> list[str]:
    return [line for line in lines if not line.startswith('006.png')]


@pytest.mark.parametrize(('change', 'part'), [
    (without_image, 'odometry is missing for 006.png'),
    (lambda lines: [*lines[:7], '006.png,a,b,c', *lines[8:]], 'line 8: is not a name and three numbers'),
    (lambda lines: ['x,y,yaw', *lines[1:]], 'line 1: the header must be "image,x,y,yaw"'),
])  # fmt: skip
def test_bad_odometry_is_one_line(scene, tmp_path, fault, change, part):
    (tmp_path / 'odom.csv').write_text('\n'.join(change((scene / 'odom.csv').read_text().splitlines())))
    given = folder_options(scene, odometry=tmp_path / 'odom.csv')
    assert part in fault(*given, '--out', tmp_path / 'out')


@pytest.mark.parametrize(('stamps', 'part'), [
    ([], 'has no odometry'),
    ([0, 1, 2, 1, 3], '/odom: its stamps run backwards 0.200 s after the first'),
    ([0, 1], '/odom: odometry is missing around image'),
])  # fmt: skip
def test_a_bag_with_bad_odometry_is_one_line(scene, tmp_path, fault, stamps, part):
    image = cv2.imread(str(scene / 'images' / '000.png'), cv2.IMREAD_GRAYSCALE)
    with BagWriter(tmp_path / 'bag') as bag:
        for k in range(8):
            write_image(bag, image, START_NS + k * STEP_NS)
        for number, k in enumerate(stamps):
            message = odometry(SE2(0.1 * k, 0.0, 0.0), (0.2, 0.0), START_NS + k * STEP_NS)
            bag.write('/odom', 'nav_msgs/msg/Odometry', message, START_NS + number * STEP_NS)
    assert part in fault('--bag', tmp_path / 'bag', '--out', tmp_path / 'out')


def test_a_drive_whose_images_do_not_overlap_is_one_line(scene, tmp_path, fault):
    (tmp_path / 'images').mkdir()
    for k in range(0, 20, 4):
        shutil.copy(scene / 'images' / f'{k:03d}.png', tmp_path / 'images')
    given = folder_options(scene, images=tmp_path / 'images')
    assert 'no overlap: only' in fault(*given, '--out', tmp_path / 'out')


@pytest.mark.parametrize(('arguments', 'part'), [
    ('--images images --odometry odom.csv', '--calibration is missing'),
    ('--images images --calibration camera.yaml', '--odometry is missing'),
    ('--images none --calibration camera.yaml --odometry odom.csv', 'none: does not exist'),
    ('--bag none', 'none: does not exist'),
    ('--bag bag --out odom.csv/x', 'choose a writable place'),
    ('--bag bag --camera-rpy 0 0 0', 'camera_rpy'),
    ('--bag bag --extend none.csv', 'none.csv: cannot be read'),
    ('--bag bag --extend true.csv --known-length 0 0 1 0 1', 'give one of both'),
    ('--bag bag --image-step 2', 'image_step is 2'),
])  # fmt: skip
def test_bad_input_is_one_line_and_exit_code_1(scene, tmp_path, fault, monkeypatch, arguments, part):
    monkeypatch.chdir(scene)
    assert part in fault('--out', tmp_path, *arguments.split())


def test_workers_that_write_to_another_folder_are_an_error(scene, tmp_path, fault, monkeypatch):
    monkeypatch.setattr(InProcessRunner, 'run', lambda _, __, arguments: iter([None] * len(arguments)))
    line = fault(*folder_options(scene), '--out', tmp_path)
    assert 'use workers that see the same files under the same names' in line


def test_an_interrupt_is_one_line(scene, tmp_path, fault, monkeypatch):
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(InProcessRunner, 'run', interrupted)
    line = fault(*folder_options(scene), '--out', tmp_path, expected=130)
    assert 'give the same command again to resume' in line


@pytest.mark.newest_set_only
def test_checkpoints_of_another_survey_are_not_mixed_in(scene, tmp_path, capsys, fault):
    images = shutil.copytree(scene / 'images', tmp_path / 'images')
    given = [*folder_options(scene, images=images), '--out', tmp_path]
    assert run(capsys, *given)[0] == 0
    line = fault(*given, '--image-step', 0.5)
    assert 'another survey, which differs by its settings; remove it' in line
    os.utime(images / '004.png', (1.0, 1.0))  # another image under the same name
    line = fault(*given)
    assert 'another survey, which differs by its images; remove it' in line


def test_only_one_survey_runs_in_a_folder(scene, tmp_path, fault):
    with exclusive_lock(tmp_path / 'checkpoint', file='lock'):
        line = fault(*folder_options(scene), '--out', tmp_path)
    assert 'another survey is running there; wait for its end or choose another --out' in line
