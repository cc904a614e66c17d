"""``teach --batch`` on a rendered wall, and a one-line message for each error in the teach config."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
import yaml
from drawn_wall import Wall, look
from pair_bag import write_pairs
from place_scenes import MOUNT
from random_places import is_same
from stereo_calibrations import rectified_calibration, write_calibration
from taught_wall import CALIBRATIONS, HERE, METERS, RAW, RIG, T_MAP_PLACE, TAUGHT, WALL, raw_image, seen

from stereo_landmark.commands import teach as teach_command
from stereo_landmark.commands.locate import main as locate
from stereo_landmark.commands.teach import main
from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.files.place_file import load_images, load_place

CENTRES = (
    RIG.project((np.array([[3.0, m.y, m.z] for m in METERS]) - MOUNT.xyz) @ MOUNT.rotation)[:, :2]
    .round()
    .tolist()
)
"""Of the meters in the left image [px]."""


class TeachConfig:
    """A teach config that can be changed and run."""

    def __init__(self, folder):
        self.folder, self.places = folder, folder / 'places'
        for side, image, calibration in zip(('left', 'right'), seen(TAUGHT), CALIBRATIONS):
            cv2.imwrite(str(folder / f'{side}.png'), image)
            write_calibration(folder / f'{side}.yaml', calibration)
        self.content = {
            'name': 'wall',
            'images': {'left': 'left.png', 'right': 'right.png'},
            'calibration': {'left': 'left.yaml', 'right': 'right.yaml'},
            'camera_xyz': list(MOUNT.xyz),
            'camera_rpy': list(MOUNT.rpy),
            'T_map_place': {'x': T_MAP_PLACE.x, 'y': T_MAP_PLACE.y, 'yaw': T_MAP_PLACE.yaw},
            'targets': [
                {'name': 'meters', 'primitives': [{'kind': 'ellipse', 'near': centre} for centre in CENTRES]}
            ],
        }

    @property
    def primitives(self):
        return self.content['targets'][0]['primitives']

    def run(self, *options):
        path = self.folder / 'lesson.yaml'
        path.write_text(yaml.safe_dump(self.content))
        return main(['--batch', str(path), '--places', str(self.places), *options])

    def place(self):
        assert self.run('--replace') == 0
        return load_place(self.places / 'wall.yaml')

    def refusal(self, capsys):
        assert self.run() == 1
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith('teach: ')
        assert not (self.places / 'wall.yaml').exists()
        return line


@pytest.fixture
def config(tmp_path):
    return TeachConfig(tmp_path)


def test_the_taught_place_is_where_the_wall_is_and_is_found_again(config, tmp_path, capsys):
    place = config.place()
    names = tuple(f'meters/ellipse {i}/centre' for i in range(1, 5))
    assert place.coordinates.names == names
    true = [[3.0, meter.y, meter.z] for meter in METERS]
    assert place.coordinates.positions == pytest.approx(np.array(true), abs=0.01)
    assert place.T_map_place == T_MAP_PLACE
    said = capsys.readouterr().out
    assert 'warning' not in said
    assert 'wall is taught' in said
    options = ['--places', str(config.places), '--out', str(tmp_path / 'out')]
    options += ['--camera-xyz', *map(str, MOUNT.xyz)]
    for side, image in zip(('left', 'right'), seen(HERE)):
        cv2.imwrite(str(tmp_path / f'now_{side}.png'), image)
        options += [f'--{side}', str(tmp_path / f'now_{side}.png')]
        options += [f'--{side}-calibration', str(tmp_path / f'{side}.yaml')]
    assert locate(options) == 0


def test_a_place_is_replaced_only_on_purpose_and_by_one_that_is_found(config, capsys):
    assert config.run() == 0
    file = config.places / 'wall.yaml'
    good = file.read_bytes()
    del config.primitives[3]
    assert config.run() == 1
    assert 'exists; give --replace' in capsys.readouterr().err
    del config.primitives[1:]
    assert config.run('--replace') == 1
    assert 'wall is not recognized in its own images' in capsys.readouterr().err
    assert file.read_bytes() == good
    config.primitives.extend({'kind': 'ellipse', 'near': centre} for centre in CENTRES[1:3])
    assert config.run('--replace') == 0
    assert len(load_place(file).targets[0].primitives) == 3


def test_a_full_disk_is_reported_with_the_folder(config, monkeypatch, capsys):
    def disk_full(*_, **__):
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(teach_command, 'save_place', disk_full)
    assert (
        config.refusal(capsys) == f'teach: {config.places}: No space left on device; choose a writable place'
    )


def test_a_damaged_place_is_taught_again(config):
    config.places.mkdir()
    file = config.places / 'wall.yaml'
    file.write_text('{')
    assert config.run('--replace') == 0
    assert load_place(file).name == 'wall'


def test_regions_and_orders_choose_what_words_say(config):
    config.content['targets'] = [
        {
            'name': 'meters',
            'primitives': [
                {
                    'kind': 'ellipse',
                    'name': 'meter',
                    'region': [0, 70, 376, 110],
                    'order': 'right_to_left',
                    'count': 3,
                },
                {'kind': 'corner', 'region': [0, 100, 100, 240], 'order': 'largest_first', 'count': 1},
            ],
            'points': ['meter 1/centre', 'meter 3/centre', 'corner 1/vertex'],
        }
    ]
    (target,) = config.place().targets
    assert [part.name for part in target.primitives] == ['meter 1', 'meter 2', 'meter 3', 'corner 1']
    assert [part.kind for part in target.primitives] == [PrimitiveKind.ELLIPSE] * 3 + [PrimitiveKind.CORNER]
    centres = [part.shape.centre[0] for part in target.primitives[:3]]
    assert centres == pytest.approx(sorted((u for u, _ in CENTRES), reverse=True)[:3], abs=2.0)
    assert target.points == ('meter 1/centre', 'meter 3/centre', 'corner 1/vertex')


def test_a_size_selects_among_concentric_primitives(config, tmp_path):
    rim = Wall((*WALL.things, *(replace(meter, radius=0.05, level=200.0) for meter in METERS)))
    for side, image in zip(('left', 'right'), look(rim, np.zeros(6), RIG)):
        cv2.imwrite(str(tmp_path / f'{side}.png'), image)
    for size in ([4.0, 8.0], [10.0, 15.0]):
        for part in config.primitives:
            part['size'] = size
        (target,) = config.place().targets
        assert all(size[0] < part.shape.semi_axes[0] < size[1] for part in target.primitives)


def test_a_quadrilateral_is_taught_by_its_corners(config):
    config.primitives.append({'kind': 'quadrilateral', 'name': 'plate', 'near': [266, 187]})
    names = [name for name in config.place().coordinates.names if 'plate' in name]
    assert names == [f'meters/plate/corner_{i}' for i in range(4)]


def test_a_bag_teaches_the_same_as_its_images(config, tmp_path):
    from_files = config.place()
    entries = [(stamp, stamp, *seen(state)) for stamp, state in ((10**9, HERE), (2 * 10**9, TAUGHT))]
    write_pairs(tmp_path / 'bag', entries, CALIBRATIONS)
    del config.content['images'], config.content['calibration']
    config.content['bag'] = {'path': 'bag', 'stamp': 1.5}
    from_bag = config.place()
    assert is_same(from_bag.rig, from_files.rig)
    # JPEG at the highest quality adds only a small error.
    assert from_bag.coordinates.positions == pytest.approx(from_files.coordinates.positions, abs=0.01)


def test_a_bag_whose_cameras_do_not_start_together_is_taught_with_its_tilt(config, tmp_path):
    stamps = [1_000_000_000 + k * 100_000_000 for k in range(16)]
    entries = [(t, t + (7_000_000 if k < 14 else 0), *seen(TAUGHT)) for k, t in enumerate(stamps)]
    write_pairs(tmp_path / 'bag', entries, CALIBRATIONS, (0.02, -0.01))
    del config.content['images'], config.content['calibration']
    config.content['bag'] = {'path': 'bag'}
    assert config.run() == 0
    assert load_images(config.places / 'wall.yaml').tilt == pytest.approx((0.02, -0.01))


def test_raw_images_are_rectified_and_kept_rectified(config, tmp_path, capsys):
    for side, image, calibration in zip(('left', 'right'), seen(TAUGHT), RAW):
        cv2.imwrite(str(tmp_path / f'{side}.png'), raw_image(image, calibration))
        write_calibration(tmp_path / f'{side}.yaml', calibration)
    assert 'not rectified' in config.refusal(capsys)
    config.content['rectify'] = True
    true = [[3.0, meter.y, meter.z] for meter in METERS]
    assert config.place().coordinates.positions == pytest.approx(np.array(true), abs=0.02)
    kept = load_images(config.places / 'wall.yaml').left.astype(float)
    assert np.median(np.abs(kept - seen(TAUGHT)[0])) < 3.0


def test_warnings_are_printed(config, capsys):
    del config.primitives[2:]
    assert config.run() == 0
    said = capsys.readouterr().out
    assert 'warning: target meters: too few points (2 taught points' in said


def replaced(name, value):
    return lambda config: config.content.update({name: value})


def choice(**entry):
    return lambda config: config.primitives.append(entry)


def write(name, change):
    def spoil(config):
        path = config.folder / name
        path.write_bytes(change(path.read_bytes()))

    return spoil


def swap(config):
    images = config.content['images']
    images['left'], images['right'] = images['right'], images['left']


def flat(config):
    write_calibration(config.folder / 'right.yaml', rectified_calibration(CALIBRATIONS[0].raw, 0.0))


def negative(config):
    write_calibration(config.folder / 'right.yaml', rectified_calibration(CALIBRATIONS[0].raw, -0.2))


def twice(config):
    config.primitives.append(config.primitives[0])


WRONG = {
    'lesson.yaml: colour does not exist': replaced('colour', 1),
    'give either images and calibration, or bag': replaced('bag', {'path': 'bag'}),
    'lesson.yaml: image_processing: setting edges.treshold does not exist': replaced(
        'image_processing', {'edges': {'treshold': 1.0}}
    ),
    'camera_xyz is [0.0], it must have at least 3 entries': replaced('camera_xyz', [0.0]),
    'camera_xyz[2] is 1000000.0, it must be at most 10': replaced('camera_xyz', [0.0, 0.0, 1e6]),
    'target meters: give each primitive either near or region': choice(kind='corner'),
    'target meters: order is only valid with region': choice(
        kind='corner', near=[1, 1], order='left_to_right'
    ),
    'no ellipse near 0, 0, the nearest is': choice(kind='ellipse', near=[0, 0]),
    'of kind ellipse in the region, 9 are needed': choice(kind='ellipse', region=[0, 0, 376, 240], count=9),
    'selected twice': twice,
    'left.png: is truncated': write('left.png', lambda data: data[:3000]),
    'left.yaml: is no YAML': write('left.yaml', lambda _: b'{'),
    'left and right are swapped': swap,
    'baseline is 0 m': flat,
    'baseline is -0.2 m': negative,
}


@pytest.mark.parametrize('words', WRONG)
def test_a_wrong_lesson_is_one_line(config, capsys, words):
    WRONG[words](config)
    assert words in config.refusal(capsys)


def test_a_bag_without_pairs_is_one_line(config, tmp_path, capsys):
    write_pairs(tmp_path / 'bag', [(10**9, 10**9 + 5_000_000, *seen(TAUGHT))], CALIBRATIONS)
    del config.content['images'], config.content['calibration']
    config.content['bag'] = {'path': 'bag'}
    assert 'no pair of valid images with matching stamps; correct stamp' in config.refusal(capsys)
    config.content['approximate_sync_tolerance_seconds'] = 0.006
    assert config.run() == 0
