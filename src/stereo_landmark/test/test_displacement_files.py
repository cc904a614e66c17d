"""Files written by ``locate``: values of the fix, and only own stale files are removed."""

import csv

import numpy as np
import pytest
from located_pairs import COVARIANCE, with_fix, without_fix
from taught_wall import HERE

from stereo_landmark.commands import locate
from stereo_landmark.files import displacement_files
from stereo_landmark.files.displacement_files import LocatedFrame, save_displacements


def disk_full(*_):
    raise OSError(28, 'No space left on device')


def frame(pair):
    return LocatedFrame('left.png', pair.stamp_ns, pair)


def test_the_table_contains_the_fix_with_its_standard_deviations(tmp_path):
    save_displacements(tmp_path, [frame(with_fix())])
    (row,) = csv.DictReader((tmp_path / 'poses.csv').open())
    values, sigmas = ([float(row[kind + name]) for name in ('x', 'y', 'z', 'yaw')] for kind in ('', 'sigma_'))
    assert values == pytest.approx([HERE[0], HERE[1], 0.02, HERE[3]])
    assert sigmas == pytest.approx(np.sqrt(np.diag(COVARIANCE)))


def test_trajectories_of_the_run_before_are_removed_and_no_others(tmp_path):
    other = tmp_path / 'displacements_of_somebody_else.tum'
    other.write_text('theirs')
    save_displacements(tmp_path, [frame(with_fix())])
    written = {path.name for path in tmp_path.glob('*.tum')} - {other.name}
    assert written == {'poses.tum', 'displacements_wall.tum'}
    save_displacements(tmp_path, [frame(without_fix())])
    assert list(tmp_path.glob('*.tum')) == [other]
    assert other.read_text() == 'theirs'


def test_what_was_there_is_there_until_the_new_files_are(tmp_path, monkeypatch):
    save_displacements(tmp_path, [frame(with_fix())])

    monkeypatch.setattr(displacement_files, 'save_tum', disk_full)
    with pytest.raises(OSError, match='No space'):
        save_displacements(tmp_path, [frame(with_fix(in_map=False))])
    assert (tmp_path / 'poses.tum').exists()


def test_a_full_disk_is_reported_with_the_folder(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(locate, 'locate', lambda _: [frame(with_fix())])
    monkeypatch.setattr(locate, 'save_displacements', disk_full)
    assert locate.main(['--places', 'places', '--bag', 'bag', '--out', str(tmp_path)]) == 1
    line = f'locate: {tmp_path}: No space left on device; choose a writable place\n'
    assert capsys.readouterr().err == line


@pytest.mark.parametrize('text', ['', 'a,b\n1,2\n', '\x00\n"', 'image,stamp\n'])
def test_a_foreign_table_names_no_files(tmp_path, text):
    (tmp_path / 'poses.csv').write_text(text)
    (tmp_path / 'poses.tum').write_text('theirs')
    save_displacements(tmp_path, [frame(without_fix())])
    assert (tmp_path / 'poses.tum').read_text() == 'theirs'
