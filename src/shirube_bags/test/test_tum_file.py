"""TUM files keep all digits, and malformed lines are reported."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shirube_bags.errors import TumFileError
from shirube_bags.trajectory import make_trajectory, planar_trajectory
from shirube_bags.trajectory_files import load_tum, save_tum

GOOD = '1.0 1 2 3 0 0 0 1'


def test_a_trajectory_is_the_same_after_its_file(tmp_path):
    rng = np.random.default_rng(1)
    stamps = 1_700_000_000_000_000_001 + np.arange(30) * 33_333_333
    turns = Rotation.random(30, random_state=1).as_quat()
    trajectory = make_trajectory(stamps, rng.normal(0, 1000, (30, 3)), turns)
    save_tum(tmp_path / 'a.tum', trajectory)
    loaded = load_tum(tmp_path / 'a.tum')
    np.testing.assert_array_equal(loaded.stamps_ns, trajectory.stamps_ns)
    np.testing.assert_array_equal(loaded.positions, trajectory.positions)
    np.testing.assert_allclose(loaded.quaternions, trajectory.quaternions, atol=1e-15)


def test_evo_reads_the_same_trajectory(tmp_path):
    file_interface = pytest.importorskip('evo.tools.file_interface')
    trajectory = planar_trajectory([10**9, 2 * 10**9], [[1, 2, 0.1], [3, 4, -3.0]])
    save_tum(tmp_path / 'a.tum', trajectory)
    theirs = file_interface.read_tum_trajectory_file(str(tmp_path / 'a.tum'))
    np.testing.assert_allclose(theirs.timestamps, [1.0, 2.0])
    np.testing.assert_allclose(theirs.positions_xyz, trajectory.positions)
    np.testing.assert_allclose(theirs.orientations_quat_wxyz, trajectory.quaternions[:, [3, 0, 1, 2]])


def test_comments_and_empty_lines_are_skipped(tmp_path):
    (tmp_path / 'a.tum').write_text(f'# stamp x y z\n\n  {GOOD}  \n')
    np.testing.assert_array_equal(load_tum(tmp_path / 'a.tum').positions, [[1, 2, 3]])


@pytest.mark.parametrize(
    ('lines', 'message'),
    [
        ([GOOD, '2.0 1 2 3 0 0 1'], 'line 3: 7 fields instead of 8'),
        ([GOOD, '2.0 1 2 three 0 0 0 1'], 'line 3: .*three.* as numbers'),
        (['two 1 2 3 0 0 0 1'], 'line 2: .*two.* no time'),
        ([GOOD, '2.0 nan 2 3 0 0 0 1'], 'line 3: a position that is not finite'),
        ([GOOD, '', '2.0 1 2 inf 0 0 0 1'], 'line 4: a position that is not finite'),
        (['2.0 1 2 3 0 0 0 0'], 'line 2: a quaternion not of length 1'),
        (['2.0 1 2 3 0 0 0 nan'], 'line 2: a quaternion not of length 1'),
        (['nan 1 2 3 0 0 0 1'], 'line 2: .* no time'),
        ([GOOD, '1.000 4 5 6 0 0 0 1'], 'line 3: duplicate stamp'),
        ([], 'has no poses'),
    ],
)
def test_bad_lines_are_refused_with_their_number(tmp_path, lines, message):
    path = tmp_path / 'bad.tum'
    path.write_text('\n'.join(['# comment', *lines]))
    with pytest.raises(TumFileError, match=message) as error:
        load_tum(path)
    assert str(path) in str(error.value)
    assert '\n' not in str(error.value)


def test_what_is_no_text_is_refused(tmp_path):
    (tmp_path / 'a.tum').write_bytes(b'\xff\xfe\x00\x80')
    with pytest.raises(TumFileError, match='not a text file'):
        load_tum(tmp_path / 'a.tum')


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(TumFileError, match='cannot be read'):
        load_tum(tmp_path / 'none.tum')


def test_an_unwritable_place_is_refused(tmp_path):
    (tmp_path / 'file').touch()
    with pytest.raises(TumFileError, match='cannot be written'):
        save_tum(tmp_path / 'file' / 'a.tum', planar_trajectory([1], [[0, 0, 0]]))
