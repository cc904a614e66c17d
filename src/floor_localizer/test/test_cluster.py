"""Index and survey on a separately started dask cluster, whose worker runs in another folder."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from dot_maps import random_map
from survey_scene import FLAGS, SMALL_SIZE, record_drive

from floor_localizer.commands import build_map, index_map
from floor_localizer.files.dot_map_file import save_csv

pytest.importorskip('distributed')
pytestmark = [pytest.mark.newest_set_only, pytest.mark.timeout(300)]


@pytest.fixture(scope='module')
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Yield the address of a scheduler with one worker."""
    folder = tmp_path_factory.mktemp('cluster')
    scheduler_options = ('--scheduler-file', 'scheduler.json', '--no-dashboard')
    commands = (
        ('scheduler', '--host', '127.0.0.1', '--port', '0', *scheduler_options),
        ('worker', '--nthreads', '1', '--no-nanny', '--local-directory', '.', *scheduler_options),
    )
    processes = [
        subprocess.Popen(
            [sys.executable, '-m', 'dask', *command], cwd=folder, stderr=subprocess.DEVNULL, start_new_session=True
        )
        for command in commands
    ]
    try:
        yield _address(folder / 'scheduler.json')
    finally:
        for process in reversed(processes):
            os.killpg(process.pid, signal.SIGINT)
            process.wait(30.0)


def _address(path: Path) -> str:
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline:
        try:
            return str(json.loads(path.read_text())['address'])
        except (FileNotFoundError, ValueError):
            time.sleep(0.05)
    raise AssertionError('the scheduler did not start')


def test_an_index_is_the_same_from_a_cluster(scheduler, tmp_path, monkeypatch):
    save_csv(tmp_path / 'floor.csv', random_map(3, (0.5, 0.4)))
    monkeypatch.chdir(tmp_path)
    for out, where in (('here.dotmap', ['--workers', '1']), ('there.dotmap', ['--scheduler', scheduler])):
        assert index_map.main(['floor.csv', '--out', out, *where]) == 0
    assert Path('there.dotmap').read_bytes() == Path('here.dotmap').read_bytes()


def test_a_survey_is_the_same_from_a_cluster(scheduler, tmp_path_factory, monkeypatch):
    scene = record_drive(tmp_path_factory.mktemp('drive'), SMALL_SIZE)
    monkeypatch.chdir(scene)
    options = ['--bag', 'bag', *FLAGS]
    assert build_map.main([*options, '--out', 'here']) == 0
    assert build_map.main([*options, '--out', 'there', '--scheduler', scheduler]) == 0
    for name in ('map.csv', 'observations.csv', 'images.csv', 'report.txt'):
        assert (scene / 'there' / name).read_bytes() == (scene / 'here' / name).read_bytes()
    for part in (scene / 'here' / 'checkpoint').glob('*.npz'):
        assert (scene / 'there' / 'checkpoint' / part.name).exists()
