"""``locate`` on rendered walls: poses, and a one-line message for each error."""

import csv
import subprocess
import sys

import cv2
import numpy as np
import pytest
from pair_bag import write_pairs
from stereo_calibrations import rectified_calibration, write_calibration
from taught_wall import CALIBRATIONS, CAMERA, HERE, RAW, T_MAP_PLACE, TAUGHT, raw_image, seen, write_files

from shirube_bags.trajectory_files import load_tum
from shirube_core.geometry import SE2, PinholeCamera
from stereo_landmark.commands.locate import main


@pytest.fixture(scope='module')
def once(tmp_path_factory):
    return write_files(tmp_path_factory.mktemp('wall'))


@pytest.fixture
def files(tmp_path, once):
    """A private copy of the files, to be corrupted."""
    return write_files(tmp_path)


def refusal(capsys, *options):
    """Return the one-line error of the command."""
    assert main(options) == 1
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith('locate: ')]
    return line


def test_the_pose_is_found_in_the_place_and_in_the_map(once, tmp_path, capsys):
    assert main(once.options('--out', str(tmp_path))) == 0
    (row,) = csv.DictReader((tmp_path / 'poses.csv').open())
    x, y, z, yaw = (float(row[name]) for name in ('x', 'y', 'z', 'yaw'))
    assert (x, y, z, yaw) == pytest.approx(HERE[:4], abs=0.01)
    assert (row['place'], row['targets'], row['reason']) == ('wall', 'meters', '')
    assert all(0.0 < float(row[f'sigma_{name}']) < 0.02 for name in ('x', 'y', 'z', 'yaw'))
    T_map_base = T_MAP_PLACE @ SE2(x, y, yaw)
    pose = load_tum(tmp_path / 'poses.tum')
    assert pose.positions[0, :2] == pytest.approx([T_map_base.x, T_map_base.y], abs=1e-5)
    displacement = load_tum(tmp_path / 'displacements_wall.tum')
    assert displacement.positions[0, :2] == pytest.approx([x, y], abs=1e-5)
    assert '1 of 1 pairs have a displacement' in capsys.readouterr().out


def test_the_closed_form_finds_it_too(once, tmp_path):
    assert main(once.options('--out', str(tmp_path), '--method', 'closed_form')) == 0
    (row,) = csv.DictReader((tmp_path / 'poses.csv').open())
    assert [float(row[name]) for name in ('x', 'y', 'yaw')] == pytest.approx([0.15, -0.1, 0.06], abs=0.02)


def test_raw_images_are_rectified_when_asked_for_and_recognized_when_not(files, tmp_path, capsys):
    for side, image, calibration in zip(('left', 'right'), seen(HERE), RAW):
        cv2.imwrite(str(files.images[side]), raw_image(image, calibration))
        write_calibration(files.calibrations[side], calibration)
    out = ('--out', str(tmp_path / 'out'))
    assert main(files.options('--rectify', *out)) == 0
    (row,) = csv.DictReader((tmp_path / 'out/poses.csv').open())
    assert [float(row[name]) for name in ('x', 'y', 'yaw')] == pytest.approx([0.15, -0.1, 0.06], abs=0.03)
    capsys.readouterr()
    assert 'not rectified; give rectified images, or raw ones with rectify' in refusal(
        capsys, *files.options(*out)
    )


def test_left_and_right_swapped_are_recognized(files, capsys):
    files.images['left'], files.images['right'] = files.images['right'], files.images['left']
    assert 'left and right are swapped' in refusal(capsys, *files.options())


@pytest.mark.parametrize('x', [0.0, -0.2])
def test_a_baseline_of_zero_or_of_the_wrong_sign_is_refused(files, capsys, x):
    write_calibration(files.calibrations['right'], rectified_calibration(CAMERA, x))
    assert f'baseline is {x:g} m, it must be positive' in refusal(capsys, *files.options())


def test_a_place_of_other_cameras_is_refused(files, capsys):
    other = PinholeCamera(376, 240, 351.0, 351.0, 187.5, 119.5)
    for side, x in (('left', 0.0), ('right', 0.2)):
        write_calibration(files.calibrations[side], rectified_calibration(other, x))
    assert 'place wall was taught with other cameras' in refusal(capsys, *files.options())


def test_another_mount_is_refused(once, capsys):
    line = refusal(capsys, *once.options(), '--camera-xyz', '0', '0', '1')
    assert 'place wall was taught with camera_xyz [0.2, 0.1, 0.6], now it is [0, 0, 1]' in line


def test_a_truncated_image_is_refused(files, capsys):
    data = files.images['right'].read_bytes()
    files.images['right'].write_bytes(data[: len(data) // 2])
    assert 'right.png: is truncated' in refusal(capsys, *files.options())


def test_one_bad_pair_is_a_line_of_the_table_and_the_others_are_located(once, tmp_path):
    folders = {side: tmp_path / side for side in ('left', 'right')}
    for side, folder in folders.items():
        folder.mkdir()
        data = once.images[side].read_bytes()
        for number in range(9):
            is_bad = side == 'right' and 0 < number < 8
            (folder / f'{number}.png').write_bytes(data[: len(data) // 2] if is_bad else data)
    where = [word for side, folder in folders.items() for word in (f'--{side}', str(folder))]
    assert main(once.options(*where, '--out', str(tmp_path / 'out'))) == 0
    rows = list(csv.DictReader((tmp_path / 'out/poses.csv').open()))
    assert [row['place'] for row in rows] == ['wall', *[''] * 7, 'wall']
    assert all('right/1.png: is truncated' in row['reason'] for row in rows[1:2])


def test_an_image_of_another_size_is_refused(files, capsys):
    cv2.imwrite(str(files.images['left']), np.zeros((480, 640), np.uint8))
    cv2.imwrite(str(files.images['right']), np.zeros((480, 640), np.uint8))
    assert 'is 640x480' in refusal(capsys, *files.options())


def test_a_place_file_against_the_schema_is_refused(files, capsys):
    path = files.places / 'wall.yaml'
    path.write_text(path.read_text().replace('baseline: ', 'base_line: '))
    line = refusal(capsys, *files.options())
    assert 'wall.yaml: stereo_calibration.base_line does not exist, did you mean baseline?' in line


@pytest.mark.parametrize(
    ('options', 'words'),
    [
        (('--rate', '0'), '--rate must be above 0'),
        (('--rate', 'nan'), '--rate must be above 0'),
        (('--rate', '1e-300'), '--rate must be above 0'),
        (('--method', 'guess'), "setting place.method is 'guess'"),
        (('--places', '/nowhere'), '/nowhere: is not a folder'),
        (('--left', '/nowhere.png'), '/nowhere.png: does not exist'),
        (('--right-calibration', '/nowhere.yaml'), '/nowhere.yaml: cannot be read'),
        (('--out', '/dev/null/out'), 'choose a writable place'),
    ],
)
def test_a_wrong_option_is_one_line(once, capsys, options, words):
    assert words in refusal(capsys, *once.options(*options))


def test_unequal_numbers_of_images_are_refused(once, capsys):
    right = [str(once.images['right'])] * 2
    assert 'there are 1 left and 2 right images' in refusal(capsys, *once.options('--right', *right))


def test_a_view_of_another_scene_is_reported_with_its_reason(files, tmp_path, capsys):
    for side in ('left', 'right'):
        cv2.imwrite(str(files.images[side]), np.full((240, 376), 120, np.uint8))
    assert 'no pair has a displacement: no similar shapes in view' in refusal(
        capsys, *files.options('--out', str(tmp_path / 'out'))
    )
    (row,) = csv.DictReader((tmp_path / 'out/poses.csv').open())
    assert row['reason'] == 'no similar shapes in view'
    assert 'meters' in row['detail']


@pytest.mark.newest_set_only
def test_the_command_without_ros_ends_without_a_traceback(files):
    program = subprocess.run(
        [sys.executable, '-m', 'stereo_landmark.commands.locate', *files.options('--places', '/nowhere')],
        capture_output=True,
        text=True,
        check=False,
    )
    assert program.returncode == 1
    assert program.stderr.splitlines() == [
        'locate: /nowhere: is not a folder; give the folder with the taught places'
    ]


START = 1_700_000_000_123_456_789
FRAME = 100_000_000


def bag_options(files, path, *more):
    return ['--places', str(files.places), '--camera-xyz', '0.2', '0.1', '0.6', '--bag', str(path), *more]


def test_a_bag_gives_its_poses_with_their_stamps(once, tmp_path):
    stamps = [START + number * FRAME for number in range(3)]
    entries = [(stamp, stamp, *seen(state)) for stamp, state in zip(stamps, (TAUGHT, HERE, TAUGHT))]
    write_pairs(tmp_path / 'bag', entries, CALIBRATIONS)
    assert main(bag_options(once, tmp_path / 'bag', '--out', str(tmp_path / 'out'))) == 0
    trajectory = load_tum(tmp_path / 'out/displacements_wall.tum')
    assert trajectory.stamps_ns.tolist() == stamps
    assert trajectory.positions[:, :2] == pytest.approx(
        np.array([[0.0, 0.0], HERE[:2], [0.0, 0.0]]), abs=0.02
    )


def test_unequal_stamps_are_reported_and_paired_on_request(once, tmp_path, capsys):
    entries = [(START + k * FRAME, START + k * FRAME + 3_000_000, *seen(HERE)) for k in range(2)]
    write_pairs(tmp_path / 'bag', entries, CALIBRATIONS)
    out = ('--out', str(tmp_path / 'out'))
    line = refusal(capsys, *bag_options(once, tmp_path / 'bag', *out))
    assert 'no common stamps; give --approximate-sync' in line
    assert main(bag_options(once, tmp_path / 'bag', *out, '--approximate-sync', '0.005')) == 0
    assert len(load_tum(tmp_path / 'out/displacements_wall.tum')) == 2


def test_a_bag_of_other_cameras_ends_with_the_line_that_says_so(once, tmp_path, capsys):
    other = PinholeCamera(376, 240, 351.0, 351.0, 187.5, 119.5)
    calibrations = rectified_calibration(other), rectified_calibration(other, 0.2)
    write_pairs(tmp_path / 'bag', [(START, START, *seen(HERE))], calibrations)
    line = refusal(capsys, *bag_options(once, tmp_path / 'bag', '--out', str(tmp_path / 'out')))
    assert 'no pair has a displacement: place wall was taught with other cameras' in line
