"""A map built in parts equals the map built at once, byte for byte, even after crashes and a full disk."""

import errno
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dot_maps import random_map
from scipy.spatial import cKDTree

from floor_localizer.core.dots import DotMap, level_at
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.independent_tasks import InProcessRunner
from floor_localizer.files.binary_format import load_binary
from floor_localizer.files.csv_format import save_csv
from floor_localizer.files.dot_map_file import load_dots_and_index, write_indexed_map
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


class Backwards:
    """Runs tasks in reverse order, as a cluster might."""

    def run(self, function: Callable[..., Any], arguments: Sequence[tuple[Any, ...]]) -> Iterator[None]:
        return InProcessRunner().run(function, arguments[::-1])


class Dying:
    """Exits after some tasks."""

    def __init__(self, tasks: int) -> None:
        self.left = tasks

    def run(self, function: Callable[..., Any], arguments: Sequence[tuple[Any, ...]]) -> Iterator[None]:
        for _ in InProcessRunner().run(function, arguments):
            self.left -= 1
            if self.left <= 0:
                raise SystemExit
            yield


@pytest.mark.parametrize('sizes', [SMALL, PartSizes(1 << 20, 10**6), PartSizes(2500, 100)])
@pytest.mark.parametrize('runner', [InProcessRunner(), Backwards()])
def test_parts_make_the_same_bytes_as_the_whole(source, at_once, tmp_path, sizes, runner):
    IndexBuild([source], tmp_path / 'map', runner, sizes).run()
    assert (tmp_path / 'map').read_bytes() == at_once
    assert [path.name for path in tmp_path.iterdir()] == ['map']


def test_a_build_that_dies_again_and_again_ends_with_the_same_bytes(source, at_once, tmp_path):
    for tasks in (1, 4, 3, 6):
        with pytest.raises(SystemExit):
            IndexBuild([source], tmp_path / 'map', Dying(tasks), SMALL).run()
        assert not (tmp_path / 'map').exists()
    IndexBuild([source], tmp_path / 'map', InProcessRunner(), SMALL).run()
    assert (tmp_path / 'map').read_bytes() == at_once


def test_what_is_done_is_not_done_again(source, tmp_path, monkeypatch):
    with pytest.raises(SystemExit):
        IndexBuild([source], tmp_path / 'map', Dying(5), SMALL).run()
    done = {path: path.stat().st_mtime_ns for path in (tmp_path / 'map.parts').glob('read-*.json')}
    assert len(done) == 5
    with pytest.raises(SystemExit):
        IndexBuild([source], tmp_path / 'map', Dying(2), SMALL).run()
    assert all(path.stat().st_mtime_ns == stamp for path, stamp in done.items())


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
            IndexBuild([source], tmp_path / 'map', InProcessRunner(), SMALL).run()
    assert not (tmp_path / 'map').exists()
    IndexBuild([source], tmp_path / 'map', InProcessRunner(), SMALL).run()
    assert (tmp_path / 'map').read_bytes() == at_once


def test_parts_of_another_map_are_not_mixed_in(source, tmp_path):
    with pytest.raises(SystemExit):
        IndexBuild([source], tmp_path / 'map', Dying(3), SMALL).run()
    other = tmp_path / 'floor.csv'
    other.write_bytes(source.read_bytes().replace(b'7', b'8'))
    with pytest.raises(
        FloorLocalizerError, match='another map or version; remove it or choose another --out'
    ):
        IndexBuild([other], tmp_path / 'map', InProcessRunner(), SMALL).run()


def test_levels_are_arranged_side_by_side(tmp_path):
    floors = [random_map(seed, (0.4, 0.3)) for seed in (5, 6)]
    shifted = DotMap(floors[1].points - 30.0, np.full(len(floors[1]), np.nan))
    paths = [tmp_path / 'ground.csv', tmp_path / 'first.csv']
    for path, floor in zip(paths, (floors[0], shifted)):
        save_csv(path, floor)
    IndexBuild(paths, tmp_path / 'house.dotmap', InProcessRunner(), SMALL).run()
    found = load_binary(tmp_path / 'house.dotmap').floor
    assert [level.name for level in found.levels] == ['ground', 'first']
    assert len(found.grid.points) == len(floors[0]) + len(shifted)
    for level, floor in zip(found.levels, (floors[0], shifted)):
        own = np.array([p for p in found.grid.points.astype(float) if level_at(found.levels, *p) == level])
        back = own - level.offset
        distances, _ = cKDTree(back).query(floor.points)
        assert len(own) == len(floor)
        assert distances.max() < 5e-6


@pytest.mark.parametrize(
    ('old', 'new', 'part'),
    [
        (b'x,y,diameter', b'a,b,c', 'line 1: the header is "a,b,c"'),
        (None, b'0.1,zero,0.002\n', 'y is "zero", not a number'),
        (None, b'0.1,inf,0.002\n', 'y is not finite'),
        (None, b'0.1,0.2,-0.002\n', 'diameter is -0.002'),
        (None, b'0.1,0.2\n', 'has 2 fields instead of 3'),
        (None, b'900.1,800.2,\n', 'dots'),
    ],
)
def test_a_malformed_line_is_named(source, tmp_path, old, new, part):
    path = tmp_path / 'bad.csv'
    content = source.read_bytes()
    path.write_bytes(content.replace(old, new) if old else content + new)
    if part == 'dots':  # a distant dot is valid
        IndexBuild([path], tmp_path / 'map', InProcessRunner(), SMALL).run()
        return
    with pytest.raises(FloorLocalizerError, match=part) as caught:
        IndexBuild([path], tmp_path / 'map', InProcessRunner(), SMALL).run()
    if old is None:
        assert f'line {content.count(10) + 1}' in str(caught.value)


def test_a_duplicate_dot_is_named(source, tmp_path):
    path = tmp_path / 'twice.csv'
    content = source.read_bytes()
    path.write_bytes(content + content.splitlines(keepends=True)[40])
    with pytest.raises(FloorLocalizerError, match='is in the map twice'):
        IndexBuild([path], tmp_path / 'map', InProcessRunner(), SMALL).run()


def test_millimetres_are_refused(source, tmp_path):
    path = tmp_path / 'mm.csv'
    rows = np.loadtxt(source, delimiter=',', skiprows=1, usecols=(0, 1)) * 1000.0
    save_csv(path, DotMap(rows, np.full(len(rows), np.nan)))
    with pytest.raises(FloorLocalizerError, match='looks like millimetres'):
        IndexBuild([path], tmp_path / 'map', InProcessRunner(), SMALL).run()
