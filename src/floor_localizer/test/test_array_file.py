import json
import subprocess
import sys

import numpy as np
import pytest

from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.files.array_file import DISK_FULL_ERRORS, DiskArrayStore, write_array

# A limit on the size of files stands in for a full disk; in pytest's own process it would hold for pytest's log, too.
FULL_DISK = """
import json, resource, sys
from pathlib import Path
import numpy as np
from floor_localizer.files.array_file import DiskArrayStore
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]),) * 2)
results = []
for number in map(int, sys.argv[3:]):
    path = Path(sys.argv[2]) / str(number)
    array, fault = np.arange(float(number)), None
    shelf = DiskArrayStore(path)
    shelf.put('block', 0, np.ones(2), np.eye(2))
    before = len(list(path.iterdir()))
    try:
        shelf.put('block', 0, np.ones(1), array)
        assert np.array_equal(shelf.get('block', 0)[1], array)
    except OSError as error:
        fault = [error.errno, str(error)]
        assert [a.tolist() for a in shelf.get('block', 0)] == [[1.0, 1.0], [[1.0, 0.0], [0.0, 1.0]]]
    results.append([fault, len(list(path.iterdir())) - before])
print(json.dumps(results))
"""
LIMIT = 3000
"""Largest file that the child may write [B]."""


def test_a_missing_array_of_another_process_is_an_error(tmp_path):
    for read in (lambda store: store.get('block', 3), lambda store: store.memory_map('states')):
        with pytest.raises(FloorLocalizerError, match='use workers that see the same files'):
            read(DiskArrayStore(tmp_path))


@pytest.mark.parametrize('array', [
    np.arange(7), np.empty((0, 2)), np.arange(6.0).reshape(2, 3).T, np.ones((2, 3, 4), np.bool_), np.array(3.5),
])  # fmt: skip
def test_numpy_reads_what_is_written(array, tmp_path):
    with (tmp_path / 'array.npy').open('wb') as file:
        write_array(file, array)
    read = np.load(tmp_path / 'array.npy', allow_pickle=False)
    assert (read.dtype, read.shape) == (array.dtype, array.shape)
    np.testing.assert_array_equal(read, array)


def test_a_full_disk_keeps_the_old_arrays_and_is_reported(tmp_path):
    # Below the limit; above it by less than what a file buffers before it writes; far above it.
    numbers = [0, 100, 420, 600, 9000]
    command = [sys.executable, '-c', FULL_DISK, str(LIMIT), str(tmp_path), *map(str, numbers)]
    child = subprocess.run(command, capture_output=True, text=True, check=True)
    results = json.loads(child.stdout)
    assert len(results) == len(numbers)
    for number, (fault, new_files) in zip(numbers, results, strict=True):
        if 8 * number < LIMIT - 200:
            assert fault is None
        else:
            assert fault[0] in DISK_FULL_ERRORS
            assert 'too large' in fault[1]
        assert new_files == 0
