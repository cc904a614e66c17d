import resource
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from floor_localizer.files.array_file import NO_ROOM, write_array
from floor_localizer.survey_files.shelf_folder import ShelfFolder

LIMIT = 3000
"""Maximum size of a file, to simulate a full disk: writing fails in the same way [bytes]."""


@pytest.fixture
def little_room() -> Iterator[None]:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize('array', [
    np.arange(7), np.empty((0, 2)), np.arange(6.0).reshape(2, 3).T, np.ones((2, 3, 4), np.bool_), np.array(3.5),
])  # fmt: skip
def test_numpy_reads_what_is_written(array: np.ndarray, tmp_path: Path) -> None:
    with (tmp_path / 'array.npy').open('wb') as file:
        write_array(file, array)
    read = np.load(tmp_path / 'array.npy', allow_pickle=False)
    assert (read.dtype, read.shape) == (array.dtype, array.shape)
    np.testing.assert_array_equal(read, array)


# Below the limit; above it by less than the write buffer; far above it.
@pytest.mark.parametrize('number', [0, 100, 420, 600, 9000])
@pytest.mark.usefixtures('little_room')
def test_without_room_nothing_is_there_and_it_is_told(number: int, tmp_path: Path) -> None:
    shelf, array = ShelfFolder(tmp_path / 'shelf'), np.arange(float(number))
    if array.nbytes < LIMIT - 200:
        shelf.put('block', 0, array)
        np.testing.assert_array_equal(shelf.get('block', 0)[0], array)
        return
    with pytest.raises(OSError, match='too large') as fault:
        shelf.put('block', 0, array)
    assert fault.value.errno in NO_ROOM
    assert list((tmp_path / 'shelf').iterdir()) == []
