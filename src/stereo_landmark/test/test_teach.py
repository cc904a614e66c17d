"""``teach --batch`` on a rendered wall, and a one-line message for each error in the teach config."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from drawn_wall import Wall, look
from pair_bag import write_pairs
from place_scenes import MOUNT
from random_places import is_same
from taught_wall import CALIBRATIONS, HERE, METERS, RIG, T_MAP_PLACE, TAUGHT, WALL, seen, write_pair

from stereo_landmark.commands import teach as teach_command
from stereo_landmark.commands.locate import main as locate
from stereo_landmark.commands.teach import main
from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.files.place_file import load_images, load_place

SECOND = 1_000_000_000
POSITIONS = np.array([[3.0, meter.y, meter.z] for meter in METERS])
CENTRES = RIG.project((POSITIONS - MOUNT.xyz) @ MOUNT.rotation)[:, :2].round().tolist()
"""Centres of the meters in the left image [px]."""


class TeachConfig:
    """A teach config that can be changed and run."""

    def __init__(self, folder):
        self.folder, self.places = folder, folder / 'places'
        self.files = write_pair(folder, TAUGHT)
        self.content = {
            'name': 'wall',
            'images': {'left': 'left.png', 'right': 'right.png'},
            'calibration': {'left': 'left.yaml', 'right': 'right.yaml'},
            'camera_xyz': list(MOUNT.xyz),
            'camera_rpy': list(MOUNT.rpy),
            'T_map_place': {'x': T_MAP_PLACE.x, 'y': T_MAP_PLACE.y, 'yaw': T_MAP_PLACE.yaw},
        }
        self.primitives = [{'kind': 'ellipse', 'near': centre} for centre in CENTRES]
        self.content['targets'] = [{'name': 'meters', 'primitives': self.primitives}]

    def use_bag(self, pairs, tilt=None, **entry):
        """Write a bag, and teach from it instead of the images."""
        write_pairs(self.folder / 'bag', pairs, tilt=tilt)
        del self.content['images'], self.content['calibration']
        self.content['bag'] = {'path': 'bag', **entry}

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
    assert place.coordinates.names == tuple(f'meters/ellipse {i}/centre' for i in range(1, 5))
    assert place.coordinates.positions == pytest.approx(POSITIONS, abs=0.01)
    assert place.T_map_place == T_MAP_PLACE
    said = capsys.readouterr().out
    assert 'warning' not in said
    assert 'wall is taught' in said
    config.files.write(seen(HERE))
    assert locate(config.files.options('--out', str(tmp_path))) == 0


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
    line = f'teach: {config.places}: No space left on device; choose a writable place'
    assert config.refusal(capsys) == line


def test_a_damaged_place_is_taught_again(config):
    config.places.mkdir()
    file = config.places / 'wall.yaml'
    file.write_text('{')
    assert config.run('--replace') == 0
    assert load_place(file).name == 'wall'


def test_regions_and_orders_choose_what_words_say(config):
    in_region = {'kind': 'ellipse', 'name': 'meter', 'region': [0, 70, 376, 110], 'order': 'right_to_left'}
    corner = {'kind': 'corner', 'region': [0, 100, 100, 240], 'order': 'largest_first', 'count': 1}
    config.primitives[:] = [{**in_region, 'count': 3}, corner]
    points = config.content['targets'][0]['points'] = ['meter 1/centre', 'meter 3/centre', 'corner 1/vertex']
    (target,) = config.place().targets
    assert [part.name for part in target.primitives] == ['meter 1', 'meter 2', 'meter 3', 'corner 1']
    assert [part.kind for part in target.primitives] == [PrimitiveKind.ELLIPSE] * 3 + [PrimitiveKind.CORNER]
    centres = [part.shape.centre[0] for part in target.primitives[:3]]
    assert centres == pytest.approx(sorted((u for u, _ in CENTRES), reverse=True)[:3], abs=2.0)
    assert target.points == tuple(points)


def test_a_size_selects_among_concentric_primitives(config):
    rim = Wall((*WALL.things, *(replace(meter, radius=0.05, level=200.0) for meter in METERS)))
    config.files.write(look(rim, np.zeros(6), RIG))
    for size in ([4.0, 8.0], [10.0, 15.0]):
        for part in config.primitives:
            part['size'] = size
        (target,) = config.place().targets
        assert all(size[0] < part.shape.semi_axes[0] < size[1] for part in target.primitives)


def test_a_quadrilateral_is_taught_by_its_corners(config):
    config.primitives.append({'kind': 'quadrilateral', 'name': 'plate', 'near': [266, 187]})
    names = [name for name in config.place().coordinates.names if 'plate' in name]
    assert names == [f'meters/plate/corner_{i}' for i in range(4)]


def test_a_target_has_image_processing_of_its_own(config, capsys):
    """Its settings override those of the place, and stay in the file."""
    (target,) = config.content['targets']
    config.content['image_processing'] = {'edges': {'threshold': 9.0, 'length_min': 10.0}}
    target['image_processing'] = {'edges': {'threshold': 4.0}}
    place = config.place()
    assert place.processing.edges.threshold == 9.0
    own = place.targets[0].processing.edges
    assert (own.threshold, own.length_min) == (4.0, 10.0)
    target['image_processing'] = {'edges': {'threshold': -1.0}}
    assert config.run('--replace') == 1
    assert 'target meters: image_processing: setting edges.threshold' in capsys.readouterr().err


def test_a_bag_teaches_the_same_as_its_images(config):
    from_files = config.place()
    config.use_bag([(SECOND, seen(HERE)), (2 * SECOND, seen(TAUGHT))], stamp=1.5)
    from_bag = config.place()
    assert is_same(from_bag.rig, from_files.rig)
    # JPEG at the highest quality adds only a small error.
    assert from_bag.coordinates.positions == pytest.approx(from_files.coordinates.positions, abs=0.01)


def test_a_bag_whose_cameras_do_not_start_together_is_taught_with_its_tilt(config):
    stamps = [SECOND + k * 100_000_000 for k in range(16)]
    pairs = [(t, seen(TAUGHT), 7_000_000 if k < 14 else 0) for k, t in enumerate(stamps)]
    config.use_bag(pairs, (0.02, -0.01))
    assert config.run() == 0
    assert load_images(config.places / 'wall.yaml').tilt == pytest.approx((0.02, -0.01))


def test_raw_images_are_rectified_and_kept_rectified(config, capsys):
    config.files.write_raw(TAUGHT)
    assert 'not rectified' in config.refusal(capsys)
    config.content['rectify'] = True
    assert config.place().coordinates.positions == pytest.approx(POSITIONS, abs=0.02)
    kept = load_images(config.places / 'wall.yaml').left.astype(float)
    assert np.median(np.abs(kept - seen(TAUGHT)[0])) < 3.0


def test_warnings_are_printed(config, capsys):
    del config.primitives[1:]
    assert config.run() == 0
    assert 'warning: target meters: too few points (1 taught point' in capsys.readouterr().out


def replaced(**fields):
    return lambda config: config.content.update(fields)


def choice(**entry):
    return lambda config: config.primitives.append(entry)


MISSPELT = {'edges': {'treshold': 1.0}}


def test_a_shape_that_cannot_be_measured_is_left_out_and_named(config, capsys):
    left, right = seen(TAUGHT)
    hidden = RIG.project((POSITIONS[:1] - MOUNT.xyz) @ MOUNT.rotation)[0, 2:].round().astype(int)
    u, v = hidden.tolist()
    right = right.copy()
    right[v - 30 : v + 30, u - 30 : u + 30] = 128
    config.files.write((left, right))
    assert config.run() == 0
    said = capsys.readouterr().out
    assert 'ellipse 1: it is not found in the right image' in said
    assert 'rows differ by' in said or 'not checked' in said
    names = [each.name for each in load_place(config.places / 'wall.yaml').targets[0].primitives]
    assert names == [f'ellipse {k}' for k in range(2, len(CENTRES) + 1)]


WRONG = [
    (replaced(colour=1), 'lesson.yaml: colour does not exist'),
    (replaced(bag={'path': 'bag'}), 'give either images and calibration, or bag'),
    (replaced(image_processing=MISSPELT), 'lesson.yaml: image_processing: setting edges.treshold does not'),
    (replaced(camera_xyz=[0.0]), 'camera_xyz is [0.0], it must have at least 3 entries'),
    (replaced(camera_xyz=[0.0, 0.0, 1e6]), 'camera_xyz[2] is 1000000.0, it must be at most 10'),
    (choice(kind='corner'), 'target meters: give each primitive either near or region'),
    (choice(kind='corner', near=[1, 1], order='left_to_right'), 'meters: order is only valid with region'),
    (choice(kind='ellipse', near=[0, 0]), 'no ellipse near 0, 0, the nearest is'),
    (choice(kind='ellipse', region=[0, 0, 376, 240], count=9), 'of kind ellipse in the region, 9 are needed'),
    (choice(kind='ellipse', near=CENTRES[0]), 'selected twice'),
    (lambda config: config.files.truncate('left'), 'left.png: is truncated'),
    (lambda config: (config.folder / 'left.yaml').write_text('{'), 'left.yaml: is no YAML'),
    (lambda config: config.files.write(seen(TAUGHT)[::-1]), 'left and right are swapped'),
    (lambda config: config.files.write(calibrations=CALIBRATIONS[:1] * 2), 'baseline is 0 m'),
]


@pytest.mark.parametrize(('change', 'words'), WRONG)
def test_a_wrong_lesson_is_one_line(config, capsys, change, words):
    change(config)
    assert words in config.refusal(capsys)


def test_a_bag_without_pairs_is_one_line(config, capsys):
    config.use_bag([(SECOND, seen(TAUGHT), 5_000_000)])
    assert 'no pair of valid images with matching stamps; correct stamp' in config.refusal(capsys)
    config.content['approximate_sync_tolerance_seconds'] = 0.006
    assert config.run() == 0
