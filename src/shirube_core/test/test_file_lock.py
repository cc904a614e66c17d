"""Only one process at a time holds the lock of a folder."""

import subprocess
import sys
import time

import pytest

from shirube_core.files import exclusive_lock

OTHER = """
import sys
from pathlib import Path
from shirube_core.files import exclusive_lock
input()
print('comes', flush=True)
with exclusive_lock(Path(sys.argv[1])):
    print((Path(sys.argv[1]) / 'done').exists())
"""


def test_another_process_waits_until_the_folder_is_free(tmp_path):
    folder = tmp_path / 'new' / 'folder'
    command, line = [sys.executable, '-c', OTHER, folder], subprocess.PIPE
    with subprocess.Popen(command, stdin=line, stdout=line, text=True) as other:
        with exclusive_lock(folder):
            other.stdin.write('begin\n')
            other.stdin.flush()
            assert other.stdout.readline() == 'comes\n'
            time.sleep(0.2)  # without the lock it would have finished by now
            (folder / 'done').touch()
        assert other.stdout.read() == 'True\n'


def test_a_locked_file_is_refused_without_waiting(tmp_path):
    for _ in range(2):  # it is released at the end
        with exclusive_lock(tmp_path / 'new', file='lock', wait=False):
            other = exclusive_lock(tmp_path / 'new', file='lock', wait=False)
            with pytest.raises(BlockingIOError):
                other.__enter__()
