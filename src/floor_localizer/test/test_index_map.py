"""The command: a map built in parts, killed and resumed; each error is one line."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from dot_maps import random_map

from floor_localizer.commands.index_map import main
from floor_localizer.files.dot_map_file import load_dots_and_index, save_csv, write_indexed_map
from floor_localizer.files.map_building import index_build
from floor_localizer.files.map_building.index_build import PartSizes

# A limit on the size of files simulates a full disk: writing fails in the same way.
COMMAND = """
import os, resource, sys
if 'MOST_BYTES' in os.environ:
    resource.setrlimit(resource.RLIMIT_FSIZE, 2 * (int(os.environ['MOST_BYTES']),))
from floor_localizer.commands import index_map
from floor_localizer.files.map_building import index_build
index_build.DEFAULT_SIZES = index_build.PartSizes(9000, 300)
sys.exit(index_map.main(sys.argv[1:]))
"""


@pytest.fixture
def source(tmp_path: Path) -> Path:
    save_csv(tmp_path / 'floor.csv', random_map(3, (0.9, 0.8)))
    return tmp_path / 'floor.csv'


def go_on(monkeypatch: pytest.MonkeyPatch, source: Path, out: Path) -> int:
    """Give the command again, with the same sizes of parts, and return its exit code."""
    monkeypatch.setattr(index_build, 'DEFAULT_SIZES', PartSizes(9000, 300))
    return main([str(source), '--out', str(out), '--workers', '1'])


def expected(source: Path) -> bytes:
    path = source.with_name('at_once.dotmap')
    write_indexed_map(path, *load_dots_and_index(source))
    return path.read_bytes()


def start(*arguments: object, **environment: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, '-c', COMMAND, *map(str, arguments), '--workers', '1'],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env=os.environ | environment,
    )


@pytest.mark.newest_set_only
def test_a_build_that_was_killed_goes_on(source, tmp_path, monkeypatch):
    out = tmp_path / 'floor.dotmap'
    process = start(source, '--out', out)
    parts = tmp_path / 'floor.dotmap.parts'
    while not list(parts.glob('cut-*.json')) and process.poll() is None:
        time.sleep(0.005)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    assert not out.exists()
    assert go_on(monkeypatch, source, out) == 0
    assert out.read_bytes() == expected(source)
    assert not parts.exists()


@pytest.mark.newest_set_only
def test_a_full_disk_is_one_line_and_nothing_is_lost(source, tmp_path, monkeypatch):
    out = tmp_path / 'floor.dotmap'
    _, error = start(source, '--out', out, MOST_BYTES='90000').communicate()
    assert len([line for line in error.splitlines() if line.startswith('index_map: ')]) == 1
    assert 'Traceback' not in error
    assert 'disk full' in error
    assert 'completed tasks are kept' in error
    assert not out.exists()
    assert main([str(source), '--out', str(out), '--workers', '1']) == 1  # other sizes of parts
    assert go_on(monkeypatch, source, out) == 0
    assert out.read_bytes() == expected(source)


@pytest.mark.parametrize(('arguments', 'part'), [
    ('none.csv --out x.dotmap', 'none.csv: cannot be read (No such file or directory)'),
    ('floor.csv --out floor.csv/x.dotmap', 'choose a writable place'),
    ('floor.csv empty.csv --out x.dotmap', 'empty.csv, line 1: the header is ""'),
    ('floor.csv few.csv --out x.dotmap', 'few.csv: has 1 dots'),
    ('floor.csv --out x.dotmap --scheduler tcp://127.0.0.1:9', 'does not answer'),
])  # fmt: skip
@pytest.mark.newest_set_only
def test_bad_input_is_one_line_and_exit_code_1(source, refusal, monkeypatch, arguments, part):
    monkeypatch.chdir(source.parent)
    monkeypatch.setattr('floor_localizer.commands.options._SCHEDULER_TIMEOUT', 0.3)
    Path('empty.csv').touch()
    Path('few.csv').write_text('x,y,diameter\n0.1,0.2,\n')
    given = arguments.split()
    assert part in refusal(main, *given, *([] if '--scheduler' in given else ['--workers', 1]), alone=False)
