"""Taught places survive a round trip through their files; malformed files give a one-line error."""

import copy
import math
from dataclasses import replace

import pytest
import yaml
from random_places import is_same, random_images, random_place

from shirube_core import files
from stereo_landmark.files.place_file import load_images, load_place, load_places, place_path, save_place
from stereo_landmark.files.yaml_file import LandmarkFileError


@pytest.fixture
def saved(tmp_path):
    return save_place(tmp_path, random_place(1), random_images(1))


def save_again(folder, **options):
    """Save another place of the same name."""
    return save_place(folder, random_place(3), random_images(3), **options)


def is_place(path, seed):
    """Return whether a file and its images are those of a random place."""
    return is_same(load_place(path), random_place(seed)) and is_same(load_images(path), random_images(seed))


@pytest.mark.parametrize('seed', range(12))
def test_a_place_is_loaded_as_it_was_saved_to_the_last_bit(tmp_path, seed):
    path = save_place(tmp_path, random_place(seed), random_images(seed))
    assert is_place(path, seed)
    text = path.read_bytes()
    assert save_place(tmp_path, load_place(path), load_images(path)).read_bytes() == text
    assert is_place(path, seed)


def test_all_places_of_a_folder_are_loaded_in_the_order_of_their_names(tmp_path):
    for name in ('stairs', 'door', 'hall'):
        save_place(tmp_path, random_place(2, name), random_images(2))
    assert [place.name for place in load_places(tmp_path)] == ['door', 'hall', 'stairs']


def test_saving_again_replaces_the_images_and_leaves_nothing_behind(tmp_path, saved):
    save_again(tmp_path)
    assert is_place(saved, 3)
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.parametrize('failing', [1, 2, 3])
def test_what_was_taught_before_survives_a_failure_at_any_file(tmp_path, saved, monkeypatch, failing):
    calls = []

    def disk_full(handle, mode):
        calls.append(mode)
        if len(calls) == failing:
            raise OSError(28, 'No space left on device')
        return fdopen(handle, mode)

    fdopen = files.os.fdopen
    monkeypatch.setattr(files.os, 'fdopen', disk_full)
    with pytest.raises(OSError, match='No space'):
        save_again(tmp_path)
    assert len(calls) == failing
    assert is_place(saved, 1)


@pytest.mark.parametrize('damage', ['', '{', 'format: shirube/taught_place\nversion: 1\nname: 7'])
def test_a_damaged_place_is_replaced_only_on_purpose(tmp_path, saved, damage):
    text = damage or saved.read_text()[:500]
    saved.write_text(text)
    with pytest.raises(LandmarkFileError):
        save_again(tmp_path)
    assert saved.read_text() == text
    save_again(tmp_path, replace_damaged=True)
    assert is_same(load_place(saved), random_place(3))


def test_a_setting_of_older_files_that_had_no_effect_is_no_fault(saved):
    content = yaml.safe_load(saved.read_text())
    content['image_processing']['edges']['neighbour_distance'] = 6.0
    saved.write_text(yaml.safe_dump(content))
    assert is_same(load_place(saved), random_place(1))


def test_a_setting_that_older_files_lack_has_its_default(saved):
    content = yaml.safe_load(saved.read_text())
    del content['image_processing']['edges']['thinning']
    saved.write_text(yaml.safe_dump(content))
    assert load_place(saved).processing.edges.thinning == 0.0


def test_a_foreign_file_is_never_written_over(tmp_path):
    path = place_path(tmp_path, 'hall')
    path.write_text('hall: opening hours')
    for work in (lambda: save_again(tmp_path, replace_damaged=True), lambda: load_places(tmp_path)):
        with pytest.raises(LandmarkFileError, match='not a taught place; move it elsewhere'):
            work()
    assert path.read_text() == 'hall: opening hours'


def test_images_of_a_copied_place_stay(tmp_path, saved):
    copied = tmp_path / 'copy.yaml'
    copied.write_text(saved.read_text().replace('name: hall', 'name: copy', 1))
    save_again(tmp_path)
    assert is_same(load_images(copied), random_images(1))
    assert is_same(load_images(saved), random_images(3))


PRIMITIVE, EDGES, POINTS = 'targets.wanted.0.primitives.0', 'image_processing.edges', 'corresponding_points'
WRONG = [
    ('format', 'shirube/map', 'format is not'),
    ('version', 2, 'version is 2, this program supports up to 1; update'),
    ('version', 0, 'version is 0, it must be 1'),
    ('version', None, 'version is missing'),
    ('colour', 'red', 'colour does not exist'),
    ('coordinate', [], 'coordinate does not exist, did you mean coordinates?'),
    ('targets', None, 'targets is missing'),
    ('targets.wanted', [], 'targets.wanted is [], it must have at least 1 entries'),
    ('name', 'stairs', 'name is stairs, but the file is called hall'),
    ('name', '../hall', "name is '../hall', it must match"),
    ('name', 'hall\n', "name is 'hall\\n', it must match"),
    ('name', 'x' * 65, "name is 'xxxxx"),
    ('targets.wanted.0.name', 'a\tb', "targets.wanted[0].name is 'a\\tb', it must match"),
    ('targets.wanted.0.name', 'a\n', "targets.wanted[0].name is 'a\\n', it must match"),
    ('stereo_calibration.left.fx', 'many', "stereo_calibration.left.fx is 'many', it must be a number"),
    ('stereo_calibration.left.cx', 1.0, 'hash does not match the calibration'),
    ('stereo_calibration.baseline', lambda baseline: -baseline, 'stereo_calibration: baseline is'),
    (f'{EDGES}.threshold', None, 'image_processing.edges.threshold is missing'),
    (f'{EDGES}.treshold', 5.0, 'setting edges.treshold does not exist, did you mean edges.threshold?'),
    (f'{EDGES}.threshold', 9999.0, 'setting edges.threshold is 9999.0, allowed is'),
    (f'{PRIMITIVE}.kind', 'hexagon', "kind is 'hexagon', it must be one of"),
    (f'{PRIMITIVE}.position', [1.0, 2.0], 'position is [1.0, 2.0], it must have at least 3 entries'),
    (f'{PRIMITIVE}.shape.colour', 1.0, 'colour does not exist, there are'),
    ('targets.wanted', lambda one: [*one, copy.deepcopy(one[0])], 'targets.wanted: meter 1 is duplicate'),
    ('coordinates', lambda coordinates: coordinates[1:], 'is missing; restore the file'),
    ('coordinates.0.xyz', [0.0, math.nan, 0.0], 'coordinates[0].xyz[1] is not a finite number'),
    ('coordinates.0.xyz', [0.0, 0.0, 1e308], 'coordinates[0].xyz[2] is not a finite number'),
    ('coordinates.0.covariance', [[-1, 0, 0], [0] * 3, [0] * 3], 'covariance is not positive semidefinite'),
    (f'{POINTS}.meter 1', None, 'corresponding_points.meter 1 is missing'),
    (f'{POINTS}.meter', ['a/b'], 'corresponding_points.meter: there is no such target'),
    (f'{POINTS}.meter 1', [], 'corresponding_points.meter 1 is [], it must have at least 1 entries'),
    (f'{POINTS}.meter 1', ['nothing/centre'], 'nothing/centre has no coordinates'),
    ('T_map_place.x', 10**400, 'T_map_place.x is not a finite number'),
    ('T_map_place.yaw', None, 'T_map_place.yaw is missing'),
    ('images.tilt', [10**400, 0], 'images.tilt[0] is not a finite number'),
    ('images.left', '../left.png', 'images.left is'),
]
"""Field, its value (None without the field, or a function of the right value), and words of the message."""


@pytest.mark.parametrize('change', WRONG, ids=lambda change: change[-1])
@pytest.mark.newest_set_only
def test_a_wrong_file_is_refused_in_one_line_with_file_and_field(saved, change):
    field, value, words = change
    content = part = yaml.safe_load(saved.read_text())
    *path, last = (int(name) if name.isdigit() else name for name in field.split('.'))
    for name in path:
        part = part[name]
    part[last] = value(part[last]) if callable(value) else value
    if value is None:
        del part[last]
    saved.write_text(yaml.safe_dump(content))
    with pytest.raises(LandmarkFileError) as fault:
        load_place(saved)
    line = str(fault.value)
    assert line.startswith(f'{saved}: ')
    assert words in line
    assert '\n' not in line
    assert len(line) < 400 + len(str(saved))


@pytest.mark.parametrize(
    ('data', 'words'),
    [
        (b'', 'holds no fields'),
        (b'[1, 2', 'is no YAML'),
        (b'a: "\n', 'is no YAML'),
        (b'format: x', 'format is not'),
        (b'\xff\xfe\x00', 'is no YAML'),
    ],
)
def test_what_is_no_yaml_is_refused(saved, data, words):
    saved.write_bytes(data)
    with pytest.raises(LandmarkFileError, match=words):
        load_place(saved)


def test_missing_files_and_folders_are_named(tmp_path, saved):
    with pytest.raises(LandmarkFileError, match='cannot be read'):
        load_place(tmp_path / 'nowhere.yaml')
    with pytest.raises(LandmarkFileError, match='is not a folder'):
        load_places(tmp_path / 'nowhere')
    (tmp_path / 'empty').mkdir()
    with pytest.raises(LandmarkFileError, match='contains no taught place'):
        load_places(tmp_path / 'empty')
    image = next(tmp_path.glob('hall_right_*.png'))
    image.write_bytes(image.read_bytes()[:1500])
    with pytest.raises(LandmarkFileError, match=r'images\.right: .*is truncated'):
        load_images(saved)
    image.unlink()
    with pytest.raises(LandmarkFileError, match=r'images\.right: .*cannot be read'):
        load_images(saved)


def test_a_place_that_could_not_be_loaded_again_is_not_saved(tmp_path):
    place = random_place(1)
    positions = place.coordinates.positions.copy()
    positions[0, 0] = math.nan
    for wrong, words in (
        ({'name': 'a/b'}, 'name is'),
        ({'targets': place.targets[:1] * 2}, 'is duplicate'),
        ({'coordinates': replace(place.coordinates, positions=positions)}, 'not a finite number'),
    ):
        with pytest.raises(LandmarkFileError, match=words):
            save_place(tmp_path, replace(place, **wrong), random_images(1))
    assert list(tmp_path.iterdir()) == []
