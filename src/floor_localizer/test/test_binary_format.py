import struct
from pathlib import Path

import numpy as np
import pytest
from dot_maps import random_map

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.errors import DotMapError
from floor_localizer.files import binary_format
from floor_localizer.files.binary_format import BinaryMap, load_binary, save_binary
from floor_localizer.files.dot_map_file import extract_dots


@pytest.fixture(scope='module')
def original() -> BinaryMap:
    floor = index_map(random_map(1))
    diameters = np.linspace(0.001, 0.003, len(floor.grid.points)).astype(np.float32)
    diameters[3] = np.nan
    return BinaryMap(floor, diameters)


@pytest.fixture
def path(tmp_path: Path, original: BinaryMap) -> Path:
    save_binary(tmp_path / 'floor.dotmap', original)
    return tmp_path / 'floor.dotmap'


def refusal(path: Path) -> str:
    with pytest.raises(DotMapError) as caught:
        load_binary(path)
    message = str(caught.value)
    assert str(path) in message
    assert '\n' not in message
    return message


def test_load_gives_what_was_saved_to_the_last_bit_and_saving_again_the_same_bytes(path, original, tmp_path):
    loaded = load_binary(path)
    save_binary(tmp_path / 'again.dotmap', loaded)
    assert (tmp_path / 'again.dotmap').read_bytes() == path.read_bytes()
    np.testing.assert_array_equal(loaded.diameters, original.diameters)
    assert loaded.floor.density == original.floor.density
    for part in ('grid', 'index', 'addresses'):
        ours, theirs = getattr(loaded.floor, part), getattr(original.floor, part)
        for name in ours._fields:
            value, expected = getattr(ours, name), getattr(theirs, name)
            assert type(value) is type(expected)
            np.testing.assert_array_equal(value, expected)


def test_arrays_are_read_only_aligned_views_of_the_file(path):
    floor = load_binary(path).floor
    for array in (floor.grid.points, floor.grid.starts, floor.index.entries, floor.addresses.bits):
        assert not array.flags.writeable
        assert not array.flags.owndata
        assert array.flags.aligned
        assert array.ctypes.data % 64 == 0


@pytest.mark.parametrize('fraction', [0.0, 1e-4, 0.01, 0.5, 0.99])
def test_a_truncated_file_is_refused(path, fraction):
    whole = path.read_bytes()
    path.write_bytes(whole[: int(fraction * len(whole))])
    assert 'truncated' in refusal(path)


def test_other_versions_parameters_headers_and_kinds_of_files_are_refused(path, tmp_path, monkeypatch):
    content = path.read_bytes()
    path.write_bytes(content[:8] + struct.pack('<I', 7) + content[12:])
    assert 'version 7' in refusal(path)
    assert 'version 3' in refusal(path)
    path.write_bytes(content.replace(b'"grid.cell"', b'"grid.sell"'))
    assert 'corrupted' in refusal(path)
    path.write_bytes(b'x,y,diameter\n0.1,0.2,0.003\n' * 10)
    assert 'is not a dot map' in refusal(path)
    assert 'No such file' in refusal(tmp_path / 'none.dotmap')
    path.write_bytes(content)
    monkeypatch.setitem(binary_format._RULES, 'parts', 99)
    assert 'another version' in refusal(path)


def test_unknown_diameters_take_no_space(path, tmp_path, original):
    save_binary(tmp_path / 'bare.dotmap', BinaryMap(original.floor, original.diameters[:0]))
    loaded = load_binary(tmp_path / 'bare.dotmap')
    assert np.isnan(extract_dots(loaded).diameters).all()
    assert len(extract_dots(loaded)) == len(original.diameters)
    assert (tmp_path / 'bare.dotmap').stat().st_size < path.stat().st_size


def test_arrays_that_do_not_belong_together_are_refused(tmp_path, original):
    save_binary(tmp_path / 'floor.dotmap', BinaryMap(original.floor, original.diameters[1:]))
    assert 'contradicts' in refusal(tmp_path / 'floor.dotmap')
