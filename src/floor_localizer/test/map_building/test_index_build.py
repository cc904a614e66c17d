"""A map built in parts equals the map built at once, byte for byte, even after crashes and a full disk."""

import errno
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dot_maps import random_map
from scipy.spatial import cKDTree
from task_runners import Dying, Elsewhere

from floor_localizer.core.dots import DotMap, level_at
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.independent_tasks import InProcessRunner, TaskRunner
from floor_localizer.files.binary_format import load_binary
from floor_localizer.files.dot_map_file import load_dots_and_index, save_csv, write_indexed_map
from floor_localizer.files.map_building import build_tasks
from floor_localizer.files.map_building.index_build import IndexBuild, PartSizes

SMALL = PartSizes(chunk_bytes=9000, stripe_dots=300)


@pytest.fixture(scope='module')
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    dot_map = random_map(3, (0.7, 0.6))
    dot_map.diameters[::9] = np.nan
    path = tmp_path_factory.mktemp('floor') / 'floor.csv'
    save_csv(path, dot_map)
    return path


@pytest.fixture(scope='module')
def at_once(source: Path) -> bytes:
    path = source.with_suffix('.dotmap')
    write_indexed_map(path, *load_dots_and_index(source))
    return path.read_bytes()


def build(sources: list[Path], out: Path, runner: TaskRunner | None = None, sizes: PartSizes = SMALL) -> bytes:
    IndexBuild(sources, out, runner or InProcessRunner(), sizes).run()
    return out.read_bytes()


@pytest.mark.parametrize('sizes', [SMALL, PartSizes(1 << 20, 10**6), PartSizes(2500, 100)])
@pytest.mark.parametrize('runner', [InProcessRunner(), Elsewhere()])
def test_parts_make_the_same_bytes_as_the_whole(source, at_once, tmp_path, sizes, runner):
    assert build([source], tmp_path / 'map', runner, sizes) == at_once
    assert [path.name for path in tmp_path.iterdir()] == ['map']


def test_a_build_that_dies_again_and_again_repeats_nothing_and_ends_with_the_same_bytes(source, at_once, tmp_path):
    done = {}
    for tasks in (5, 1, 4, 3, 6):
        with pytest.raises(SystemExit):
            build([source], tmp_path / 'map', Dying(tasks))
        assert not (tmp_path / 'map').exists()
        parts = {path: path.stat().st_mtime_ns for path in (tmp_path / 'map.parts').glob('read-*.json')}
        assert done.items() <= parts.items()
        assert len(parts) >= 5
        done = parts
    assert build([source], tmp_path / 'map') == at_once


@pytest.mark.parametrize('written', [0, 1, 7])
def test_a_full_disk_loses_nothing(source, at_once, tmp_path, monkeypatch, written):
    left = [written]
    write = build_tasks._write

    def write_until_full(*given: Any) -> None:
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, 'No space left on device')
        write(*given)

    with monkeypatch.context() as full:
        full.setattr(build_tasks, '_write', write_until_full)
        with pytest.raises(OSError, match='No space'):
            build([source], tmp_path / 'map')
    assert not (tmp_path / 'map').exists()
    assert build([source], tmp_path / 'map') == at_once


def test_parts_of_another_map_are_not_mixed_in(source, tmp_path):
    with pytest.raises(SystemExit):
        build([source], tmp_path / 'map', Dying(3))
    other = tmp_path / 'floor.csv'
    other.write_bytes(source.read_bytes().replace(b'7', b'8'))
    with pytest.raises(FloorLocalizerError, match='another map or version; remove it or choose another'):
        build([other], tmp_path / 'map')


def test_a_distant_dot_is_valid(source, tmp_path):
    (tmp_path / 'far.csv').write_text(f'{source.read_text()}900.1,800.2,\n')
    build([tmp_path / 'far.csv'], tmp_path / 'map')


def test_levels_are_arranged_side_by_side(tmp_path):
    floors = [random_map(seed, (0.4, 0.3)) for seed in (5, 6)]
    shifted = DotMap(floors[1].points - 30.0, np.full(len(floors[1]), np.nan))
    paths = [tmp_path / 'ground.csv', tmp_path / 'first.csv']
    for path, floor in zip(paths, (floors[0], shifted)):
        save_csv(path, floor)
    build(paths, tmp_path / 'house.dotmap')
    found = load_binary(tmp_path / 'house.dotmap').floor
    assert [level.name for level in found.levels] == ['ground', 'first']
    assert len(found.grid.points) == len(floors[0]) + len(shifted)
    for level, floor in zip(found.levels, (floors[0], shifted)):
        own = np.array([p for p in found.grid.points.astype(float) if level_at(found.levels, *p) == level])
        back = own - level.offset
        distances, _ = cKDTree(back).query(floor.points)
        assert len(own) == len(floor)
        assert distances.max() < 5e-6


@pytest.mark.parametrize(('line', 'part'), [
    ('0.1,zero,0.002', 'y is "zero", not a number'), ('0.1,inf,0.002', 'y is not finite'),
    ('0.1,0.2,-0.002', 'diameter is -0.002'), ('0.1,0.2', 'has 2 fields instead of 3'),
])  # fmt: skip
def test_a_malformed_line_is_named(source, tmp_path, line, part):
    path, content = tmp_path / 'bad.csv', source.read_text()
    path.write_text(f'{content}{line}\n')
    with pytest.raises(FloorLocalizerError, match=rf'line {content.count(chr(10)) + 1}\b.*{part}'):
        build([path], tmp_path / 'map')


def in_millimetres(line):
    return ','.join(f'{1000.0 * float(value)}' for value in line.split(',')[:2]) + ','


@pytest.mark.parametrize(('change', 'part'), [
    (lambda lines: ['a,b,c', *lines[1:]], 'line 1: the header is "a,b,c"'),
    (lambda lines: [*lines, lines[40]], 'is in the map twice'),
    (lambda lines: [lines[0], *map(in_millimetres, lines[1:])], 'looks like millimetres'),
])  # fmt: skip
def test_what_is_no_map_is_refused(source, tmp_path, change, part):
    path = tmp_path / 'bad.csv'
    path.write_text('\n'.join([*change(source.read_text().splitlines()), '']))
    with pytest.raises(FloorLocalizerError, match=part):
        build([path], tmp_path / 'map')
