"""``locate`` on rendered walls: poses, and a one-line message for each error."""

import csv
import subprocess
import sys

import numpy as np
import pytest
from pair_bag import write_pairs
from stereo_calibrations import rectified_calibration
from taught_wall import CALIBRATIONS, HERE, LEANING, SIDES, T_MAP_PLACE, TAUGHT, seen

from shirube_bags.trajectory_files import load_tum
from shirube_core.geometry import SE2, PinholeCamera
from stereo_landmark.commands.locate import main

OTHER = PinholeCamera(376, 240, 351.0, 351.0, 187.5, 119.5)
OTHERS = rectified_calibration(OTHER), rectified_calibration(OTHER, 0.3)
START = 1_700_000_000_123_456_789
FRAME = 100_000_000


def refusal(capsys, options):
    """Return the one-line error of the command."""
    assert main(options) == 1
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith('locate: ')]
    return line


def row_of(folder):
    """Return the only row of the table, and its x, y, z [m] and yaw [rad]."""
    (row,) = csv.DictReader((folder / 'poses.csv').open())
    return row, [float(row[name] or 'nan') for name in ('x', 'y', 'z', 'yaw')]


def test_the_pose_is_found_in_the_place_and_in_the_map(shared_files, tmp_path, capsys):
    assert main(shared_files.options('--out', str(tmp_path))) == 0
    row, (x, y, z, yaw) = row_of(tmp_path)
    assert (x, y, z, yaw) == pytest.approx(HERE[:4], abs=0.01)
    assert (row['place'], row['targets'], row['reason']) == ('wall', 'meters', '')
    assert all(0.0 < float(row[f'sigma_{name}']) < 0.02 for name in ('x', 'y', 'z', 'yaw'))
    T_map_base = T_MAP_PLACE @ SE2(x, y, yaw)
    pose = load_tum(tmp_path / 'poses.tum')
    assert pose.positions[0, :2] == pytest.approx([T_map_base.x, T_map_base.y], abs=1e-5)
    displacement = load_tum(tmp_path / 'displacements_wall.tum')
    assert displacement.positions[0, :2] == pytest.approx([x, y], abs=1e-5)
    assert '1 of 1 pairs have a displacement' in capsys.readouterr().out


@pytest.mark.parametrize(
    ('state', 'options', 'accuracy'),
    [
        (HERE, ('--method', 'closed_form'), 0.02),
        (HERE, ('--mode', 'paper'), 0.02),
        (LEANING, ('--tilt', *map(str, LEANING[4:])), 0.01),
    ],
)
def test_the_closed_form_the_paper_mode_and_a_tilted_and_raised_robot(files, tmp_path, state, options, accuracy):
    files.write(seen(state))
    assert main(files.options('--out', str(tmp_path), *options)) == 0
    assert row_of(tmp_path)[1] == pytest.approx(state[:4], abs=accuracy)


def test_raw_images_are_rectified_when_asked_for_and_recognized_when_not(files, tmp_path, capsys):
    files.write_raw(HERE)
    options = files.options('--out', str(tmp_path))
    assert main([*options, '--rectify']) == 0
    assert row_of(tmp_path)[1] == pytest.approx(HERE[:4], abs=0.03)
    capsys.readouterr()
    line = refusal(capsys, options)
    assert 'not rectified; give rectified images, or raw ones with rectify' in line


def misspell(files):
    path = files.places / 'wall.yaml'
    path.write_text(path.read_text().replace('baseline: ', 'base_line: '))


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        (lambda files: files.write(seen(HERE)[::-1]), 'left and right are swapped'),
        (lambda files: files.truncate('right'), 'right.png: is truncated'),
        (misspell, 'wall.yaml: stereo_calibration.base_line does not exist, did you mean baseline?'),
        (lambda files: files.write([np.zeros((480, 640), np.uint8)] * 2), 'is 640 x 480 px'),
        (lambda files: files.write(calibrations=CALIBRATIONS[::-1]), 'baseline is -0.2 m, it must be'),
        (lambda files: files.write(calibrations=OTHERS), 'place wall was taught with baseline'),
    ],
)
def test_a_wrong_file_is_one_line(files, capsys, change, words):
    change(files)
    assert words in refusal(capsys, files.options())


@pytest.mark.parametrize(
    ('options', 'words'),
    [
        (('--rate', 'nan'), '--rate must be above 0'),
        (('--rate', '1e-300'), '--rate must be above 0'),
        (('--method', 'guess'), "setting place.method is 'guess'"),
        (('--left', '/nowhere.png'), '/nowhere.png: does not exist'),
        (('--right-calibration', '/nowhere.yaml'), '/nowhere.yaml: cannot be read'),
        (('--out', '/dev/null/out'), 'choose a writable place'),
        (('--camera-xyz', '0', '0', '1'), 'taught with camera_xyz [0.2, 0.1, 0.6], now it is [0, 0, 1]'),
    ],
)
def test_a_wrong_option_is_one_line(shared_files, capsys, options, words):
    assert words in refusal(capsys, shared_files.options(*options))


def test_unequal_numbers_of_images_are_refused(shared_files, capsys):
    right = [str(shared_files.images['right'])] * 2
    assert 'there are 1 left and 2 right images' in refusal(capsys, shared_files.options('--right', *right))


def test_one_bad_pair_is_a_line_of_the_table_and_the_others_are_located(shared_files, tmp_path):
    where = []
    for side in SIDES:
        folder = tmp_path / side
        where += [f'--{side}', str(folder)]
        folder.mkdir()
        data = shared_files.images[side].read_bytes()
        for number in range(9):
            is_bad = side == 'right' and 0 < number < 8
            (folder / f'{number}.png').write_bytes(data[: len(data) // 2] if is_bad else data)
    assert main(shared_files.options(*where, '--out', str(tmp_path))) == 0
    rows = list(csv.DictReader((tmp_path / 'poses.csv').open()))
    assert [row['place'] for row in rows] == ['wall', *[''] * 7, 'wall']
    assert 'right/1.png: is truncated' in rows[1]['reason']


def test_a_view_of_another_scene_is_reported_with_its_reason(files, tmp_path, capsys):
    files.write([np.full((240, 376), 120, np.uint8)] * 2)
    line = refusal(capsys, files.options('--out', str(tmp_path)))
    assert 'no pair has a displacement: no similar shapes in view' in line
    row, _ = row_of(tmp_path)
    assert row['reason'] == 'no similar shapes in view'
    assert 'meters' in row['detail']


@pytest.mark.newest_set_only
def test_the_command_without_ros_ends_without_a_traceback(shared_files):
    options = shared_files.options('--places', '/nowhere')
    command = [sys.executable, '-m', 'stereo_landmark.commands.locate', *options]
    program = subprocess.run(command, capture_output=True, text=True, check=False)
    assert program.returncode == 1
    assert program.stderr == 'locate: /nowhere: is not a folder; give the folder with the taught places\n'


@pytest.fixture
def bag_options(shared_files, tmp_path):
    """Write a bag, and return the options for it."""

    def write(pairs, calibrations=CALIBRATIONS):
        bag = write_pairs(tmp_path / 'bag', pairs, calibrations)
        options = ['--places', str(shared_files.places), '--camera-xyz', '0.2', '0.1', '0.6']
        return [*options, '--bag', str(bag), '--out', str(tmp_path)]

    return write


def test_a_bag_gives_its_poses_with_their_stamps(bag_options, tmp_path):
    stamps = [START + number * FRAME for number in range(3)]
    states = (TAUGHT, HERE, TAUGHT)
    assert main(bag_options([(stamp, seen(state)) for stamp, state in zip(stamps, states)])) == 0
    trajectory = load_tum(tmp_path / 'displacements_wall.tum')
    assert trajectory.stamps_ns.tolist() == stamps
    assert trajectory.positions[:, :2] == pytest.approx(np.array(states)[:, :2], abs=0.02)


def test_unequal_stamps_are_reported_and_paired_on_request(bag_options, tmp_path, capsys):
    options = bag_options([(START + k * FRAME, seen(HERE), 3_000_000) for k in range(2)])
    assert 'no common stamps; give --approximate-sync' in refusal(capsys, options)
    assert main([*options, '--approximate-sync', '0.005']) == 0
    assert len(load_tum(tmp_path / 'displacements_wall.tum')) == 2


def test_a_bag_of_other_cameras_ends_with_the_line_that_says_so(bag_options, capsys):
    line = refusal(capsys, bag_options([(START, seen(HERE))], OTHERS))
    assert 'no pair has a displacement: place wall was taught with baseline' in line
