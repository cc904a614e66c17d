"""Taught places survive a round trip through their files; malformed files give a one-line error."""

import copy
import dataclasses

import numpy as np
import pytest
import yaml
from random_places import is_same, random_images, random_place

from shirube_core.files import atomic_file
from stereo_landmark.files.place_file import load_images, load_place, load_places, place_path, save_place
from stereo_landmark.files.yaml_file import LandmarkFileError


@pytest.fixture
def saved(tmp_path):
    return save_place(tmp_path, random_place(1), random_images(1))


@pytest.mark.parametrize('seed', range(12))
def test_a_place_is_loaded_as_it_was_saved_to_the_last_bit(tmp_path, seed):
    place, images = random_place(seed), random_images(seed)
    path = save_place(tmp_path, place, images)
    assert is_same(load_place(path), place)
    assert is_same(load_images(path), images)
    text = path.read_bytes()
    assert save_place(tmp_path, load_place(path), load_images(path)).read_bytes() == text
    assert is_same(load_images(path), images)


def test_all_places_of_a_folder_are_loaded_in_the_order_of_their_names(tmp_path):
    for name in ('stairs', 'door', 'hall'):
        save_place(tmp_path, random_place(2, name), random_images(2))
    assert [place.name for place in load_places(tmp_path)] == ['door', 'hall', 'stairs']


def test_saving_again_replaces_the_images_and_leaves_nothing_behind(tmp_path, saved):
    save_place(tmp_path, random_place(3), random_images(3))
    assert is_same(load_place(saved), random_place(3))
    assert is_same(load_images(saved), random_images(3))
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.parametrize('failing', [1, 2, 3])
def test_what_was_taught_before_survives_a_failure_at_any_file(tmp_path, saved, monkeypatch, failing):
    calls = []

    def disk_full(handle, mode):
        calls.append(mode)
        if len(calls) == failing:
            raise OSError(28, 'No space left on device')
        return fdopen(handle, mode)

    fdopen = atomic_file.os.fdopen
    monkeypatch.setattr(atomic_file.os, 'fdopen', disk_full)
    with pytest.raises(OSError, match='No space'):
        save_place(tmp_path, random_place(3), random_images(3))
    assert len(calls) == failing
    assert is_same(load_place(saved), random_place(1))
    assert is_same(load_images(saved), random_images(1))


@pytest.mark.parametrize('damage', ['', '{', 'format: shirube/taught_place\nversion: 1\nname: 7'])
def test_a_damaged_place_is_replaced_only_on_purpose(tmp_path, saved, damage):
    text = damage or saved.read_text()[:500]
    saved.write_text(text)
    with pytest.raises(LandmarkFileError):
        save_place(tmp_path, random_place(3), random_images(3))
    assert saved.read_text() == text
    save_place(tmp_path, random_place(3), random_images(3), replace_damaged=True)
    assert is_same(load_place(saved), random_place(3))


def test_a_setting_of_older_files_that_had_no_effect_is_no_fault(saved):
    content = yaml.safe_load(saved.read_text())
    content['image_processing']['edges']['neighbour_distance'] = 6.0
    saved.write_text(yaml.safe_dump(content))
    assert is_same(load_place(saved), random_place(1))


def test_a_foreign_file_is_never_written_over(tmp_path):
    path = place_path(tmp_path, 'hall')
    path.write_text('hall: opening hours')
    with pytest.raises(LandmarkFileError, match='not a taught place; move it elsewhere'):
        save_place(tmp_path, random_place(1), random_images(1), replace_damaged=True)
    with pytest.raises(LandmarkFileError, match='not a taught place; move it elsewhere'):
        load_places(tmp_path)
    assert path.read_text() == 'hall: opening hours'


def test_images_of_a_copied_place_stay(tmp_path, saved):
    copied = tmp_path / 'copy.yaml'
    copied.write_text(saved.read_text().replace('name: hall', 'name: copy', 1))
    save_place(tmp_path, random_place(3), random_images(3))
    assert is_same(load_images(copied), random_images(1))
    assert is_same(load_images(saved), random_images(3))


def changed(*path_and_value):
    """Return a change of one value, or its removal."""
    *path, last, value = path_and_value

    def change(content):
        for part in path:
            content = content[part]
        if value is None:
            del content[last]
        else:
            content[last] = value

    return change


def first_of(content):
    return content['targets']['wanted'][0]


def doubled(content):
    content['targets']['wanted'].append(copy.deepcopy(first_of(content)))


def without_coordinates(content):
    content['coordinates'] = content['coordinates'][1:]


def swapped(content):
    content['stereo_calibration']['baseline'] *= -1.0


WRONG = {
    'format is not': changed('format', 'shirube/map'),
    'version is 2, this program supports up to 1; update': changed('version', 2),
    'version is 0, it must be 1': changed('version', 0),
    'version is missing': changed('version', None),
    'colour does not exist': changed('colour', 'red'),
    'coordinate does not exist, did you mean coordinates?': changed('coordinate', []),
    'targets is missing': changed('targets', None),
    'targets.wanted is [], it must have at least 1 entries': changed('targets', 'wanted', []),
    'name is stairs, but the file is called hall': changed('name', 'stairs'),
    "name is '../hall', it must match": changed('name', '../hall'),
    "name is 'hall\\n', it must match": changed('name', 'hall\n'),
    "name is 'xxxxx": changed('name', 'x' * 65),
    "targets.wanted[0].name is 'a\\tb', it must match": changed('targets', 'wanted', 0, 'name', 'a\tb'),
    "targets.wanted[0].name is 'a\\n', it must match": changed('targets', 'wanted', 0, 'name', 'a\n'),
    "stereo_calibration.left.fx is '7 hundred', it must be a number": changed(
        'stereo_calibration', 'left', 'fx', '7 hundred'
    ),
    'hash does not match the calibration': changed('stereo_calibration', 'left', 'cx', 1.0),
    'stereo_calibration: baseline is': swapped,
    'image_processing.edges.threshold is missing': changed('image_processing', 'edges', 'threshold', None),
    'setting edges.treshold does not exist, did you mean edges.threshold?': changed(
        'image_processing', 'edges', 'treshold', 5.0
    ),
    'setting edges.threshold is 9999.0, allowed is': changed(
        'image_processing', 'edges', 'threshold', 9999.0
    ),
    "kind is 'hexagon', it must be one of": changed(
        'targets', 'wanted', 0, 'primitives', 0, 'kind', 'hexagon'
    ),
    'position is [1.0, 2.0], it must have at least 3 entries': changed(
        'targets', 'wanted', 0, 'primitives', 0, 'position', [1.0, 2.0]
    ),
    'colour does not exist, there are': changed(
        'targets', 'wanted', 0, 'primitives', 0, 'shape', 'colour', 1.0
    ),
    'targets.wanted: meter 1 is duplicate': doubled,
    'is missing; restore the file': without_coordinates,
    'corresponding_points.meter 1 is missing': changed('corresponding_points', 'meter 1', None),
    'corresponding_points.meter: there is no such target': changed('corresponding_points', 'meter', ['a/b']),
    'corresponding_points.meter 1 is [], it must have at least 1 entries': changed(
        'corresponding_points', 'meter 1', []
    ),
    'nothing/centre has no coordinates': changed('corresponding_points', 'meter 1', ['nothing/centre']),
    'coordinates[0].xyz[1] is not a finite number': changed(
        'coordinates', 0, 'xyz', [0.0, float('nan'), 0.0]
    ),
    'coordinates[0].xyz[2] is not a finite number': changed('coordinates', 0, 'xyz', [0.0, 0.0, 1e308]),
    'T_map_place.x is not a finite number': changed('T_map_place', 'x', 10**400),
    'images.tilt[0] is not a finite number': changed('images', 'tilt', [10**400, 0]),
    'covariance is not positive semidefinite': changed(
        'coordinates', 0, 'covariance', [[-1.0, 0, 0], [0, 1, 0], [0, 0, 1]]
    ),
    'T_map_place.yaw is missing': changed('T_map_place', 'yaw', None),
    'images.left is': changed('images', 'left', '../left.png'),
}


@pytest.mark.parametrize('words', WRONG)
@pytest.mark.newest_set_only
def test_a_wrong_file_is_refused_in_one_line_with_file_and_field(saved, words):
    content = yaml.safe_load(saved.read_text())
    WRONG[words](content)
    saved.write_text(yaml.safe_dump(content))
    with pytest.raises(LandmarkFileError) as fault:
        load_place(saved)
    line = str(fault.value)
    assert line.startswith(f'{saved}: ')
    assert words in line
    assert '\n' not in line
    assert len(line) < 400 + len(str(saved))


@pytest.mark.parametrize(
    ('text', 'words'),
    [('', 'holds no fields'), ('[1, 2', 'is no YAML'), ('a: "\n', 'is no YAML'), ('\xff', 'format is not')],
)
def test_what_is_no_yaml_is_refused(saved, text, words):
    saved.write_text(text if text != '\xff' else 'format: x', encoding='utf-8')
    with pytest.raises(LandmarkFileError, match=words):
        load_place(saved)
    saved.write_bytes(b'\xff\xfe\x00')
    with pytest.raises(LandmarkFileError, match='is no YAML'):
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
    positions[0, 0] = np.nan
    endless = dataclasses.replace(place.coordinates, positions=positions)
    for wrong, words in (
        (dataclasses.replace(place, name='a/b'), 'name is'),
        (dataclasses.replace(place, targets=place.targets[:1] * 2), 'is duplicate'),
        (dataclasses.replace(place, coordinates=endless), 'not a finite number'),
    ):
        with pytest.raises(LandmarkFileError, match=words):
            save_place(tmp_path, wrong, random_images(1))
    assert list(tmp_path.iterdir()) == []
