import shutil

import cv2
import numpy as np
import pytest
from survey_scene import fault_of, folder_options, run

from floor_localizer.commands.build_map import main
from floor_localizer.core.dots import DotMap
from floor_localizer.core.survey.map_comparison import compare
from floor_localizer.files.dot_map_file import load_csv, save_csv


@pytest.mark.parametrize('source', ['folder', 'bag'])
def test_a_drive_becomes_a_map(scene, tmp_path, capsys, source):
    given = folder_options(scene) if source == 'folder' else ['--bag', scene / 'bag']
    code, out, err = run(capsys, *given, '--out', tmp_path)
    assert code == 0, err
    found = compare(load_csv(scene / 'true.csv'), load_csv(tmp_path / 'map.csv'))
    assert np.percentile(np.hypot(*found.residuals.T), 90.0) < 0.0002
    assert len(found.extra) <= 3
    assert len(found.missing) < 0.08 * len(found.pairs)
    assert 'loops' in out
    assert (tmp_path / 'report.txt').read_text().strip() in out
    assert (tmp_path / 'observations.csv').read_text().startswith('x,y,diameter,count\n')
    for name in ('map.png', 'residuals.png'):
        assert cv2.imread(str(tmp_path / name)) is not None


def test_a_known_length_sets_the_scale_without_repeating_the_adjustment(scene, tmp_path, capsys, monkeypatch):
    # A camera height that is given 1 % too large makes a map that is 1 % too large.
    high = ('--out', tmp_path / 'a', '--camera-xyz', 0.05, -0.02, 0.1313, '--workers', 1)
    wrong = [str(each) for each in (*folder_options(scene), *high)]
    assert main(wrong) == 0
    truth, found = load_csv(scene / 'true.csv'), load_csv(tmp_path / 'a' / 'map.csv')
    before = compare(truth, found)
    assert 1.007 < before.scale < 1.013
    # The farthest two common dots, measured to a tenth of a millimetre.
    along = truth.points[before.pairs[:, 0]].sum(1)
    ends = before.pairs[[np.argmin(along), np.argmax(along)]]
    length = float(np.hypot(*np.diff(truth.points[ends[:, 0]], axis=0)[0])) + 0.0001
    places = found.points[ends[:, 1]].ravel()
    known = ['--known-length', *places, length]
    with monkeypatch.context() as nothing:
        nothing.setattr('floor_localizer.core.survey.submap_graph.connected_images.PoseGraphBuilder', None)
        nothing.setattr('floor_localizer.core.survey.floor_survey.bundle_adjust_blocks', None)
        assert main([*wrong, *map(str, known)]) == 0
    after = compare(truth, load_csv(tmp_path / 'a' / 'map.csv'))
    assert abs(after.scale - 1.0) < 0.0008
    known[-1] = 2 * length
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path / 'b', *known)
    assert code == 1
    assert 'check which dots were measured' in fault_of(err)


def test_a_second_drive_extends_the_map(scene, tmp_path, capsys):
    truth = load_csv(scene / 'true.csv')
    left = truth.points[:, 0] < 0.2
    save_csv(tmp_path / 'left.csv', DotMap(truth.points[left], truth.diameters[left]))
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path, '--extend', tmp_path / 'left.csv')
    assert code == 0, err
    found = load_csv(tmp_path / 'map.csv')
    np.testing.assert_allclose(found.points[: left.sum()], truth.points[left], atol=1e-6)
    assert len(found) > 1.5 * left.sum()


@pytest.mark.newest_set_only
def test_unusable_images_are_reported_and_left_out(scene, tmp_path, capsys):
    images = shutil.copytree(scene / 'images', tmp_path / 'images')
    cv2.imwrite(str(images / '005.png'), np.full((100, 120), 200, dtype=np.uint8))
    (images / '009.png').write_bytes((images / '009.png').read_bytes()[:500])
    cv2.imwrite(str(images / '012.png'), np.full((235, 235), 200, dtype=np.uint8))
    given = folder_options(scene, images=images)
    code, out, err = run(capsys, *given, '--out', tmp_path / 'out')
    assert code == 0, err
    assert '005.png: is 120 x 100 px, the calibration is for 235 x 235 px' in out
    assert '009.png: is truncated' in out
    assert '012.png: shows 0 dots' in out
    found = compare(load_csv(scene / 'true.csv'), load_csv(tmp_path / 'out' / 'map.csv'))
    assert np.percentile(np.hypot(*found.residuals.T), 90.0) < 0.0002
