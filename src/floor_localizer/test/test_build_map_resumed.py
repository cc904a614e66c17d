"""A survey that was killed or ran out of disk space resumes and gives the same map."""

import errno
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from survey_scene import FLAGS, SMALL_SIZE, fault_of, folder_options, record_drive, run

from floor_localizer.commands import build_map
from floor_localizer.commands.build_map import main
from floor_localizer.core.survey import floor_survey
from floor_localizer.core.survey.submap_graph import connected_images
from floor_localizer.files import array_file
from floor_localizer.survey_files import checkpoint
from floor_localizer.survey_files.checkpoint import Checkpoint

pytestmark = pytest.mark.newest_set_only

TABLES = ('map.csv', 'observations.csv', 'images.csv', 'report.txt')
KILLED_WHILE_ADJUSTING = """
import os, signal, sys
from floor_localizer.commands.build_map import main
from floor_localizer.files.array_file import DiskArrayStore

put = DiskArrayStore.put

def store_or_die(shelf, name, number, *arrays):
    put(shelf, name, number, *arrays)
    if name == 'found' and (shelf.folder.parents[1] / 'adjusted_1.npz').exists():
        os.killpg(0, signal.SIGKILL)

DiskArrayStore.put = store_or_die
main(sys.argv[1:])
"""


@pytest.fixture(scope='module')
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record_drive(tmp_path_factory.mktemp('drive'), SMALL_SIZE)


@pytest.fixture(scope='module')
def whole(scene: Path) -> Path:
    """Folder of a survey that was not killed."""
    assert main([*map(str, folder_options(scene)), '--out', str(scene / 'whole'), *FLAGS]) == 0
    return scene / 'whole'


def without_room(*_: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def no_detector() -> SimpleNamespace:
    def detect(_: object) -> None:
        raise AssertionError('an image is processed again')

    return SimpleNamespace(detect=detect)


def test_a_survey_killed_while_adjusting_resumes_with_that_round(scene, whole, tmp_path, capsys, monkeypatch):
    shutil.copytree(whole / 'checkpoint', tmp_path / 'checkpoint')
    for done in (*(tmp_path / 'checkpoint').glob('adjusted_*'), tmp_path / 'checkpoint' / 'linked.npz'):
        done.unlink()
    command = [sys.executable, '-c', KILLED_WHILE_ADJUSTING, *map(str, folder_options(scene))]
    child = subprocess.run(
        [*command, '--out', str(tmp_path), *FLAGS], stderr=subprocess.DEVNULL, start_new_session=True, check=False
    )
    assert child.returncode == -signal.SIGKILL
    assert list((tmp_path / 'checkpoint' / 'adjustment').glob('*/found_00000.npy'))
    adjusted, bundle_adjust_blocks = [], floor_survey.bundle_adjust_blocks
    monkeypatch.setattr(connected_images, 'PoseGraphBuilder', None)
    monkeypatch.setattr(floor_survey, 'bundle_adjust_blocks', lambda *a: adjusted.append(a) or bundle_adjust_blocks(*a))
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path)
    assert code == 0, err
    assert len(adjusted) == floor_survey.ADJUSTMENTS - 2
    for name in TABLES:
        assert (tmp_path / name).read_bytes() == (whole / name).read_bytes()


def test_a_damaged_step_is_done_again(scene, whole, tmp_path, capsys):
    shutil.copytree(whole / 'checkpoint', tmp_path / 'checkpoint')
    for name in ('linked.npz', 'adjusted_3.npz', 'adjusted_5.npz'):
        os.truncate(tmp_path / 'checkpoint' / name, 100)
    (tmp_path / '.map.png.abcd_123').touch()  # partially written result of a killed process
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path)
    assert code == 0, err
    assert (tmp_path / 'map.csv').read_bytes() == (whole / 'map.csv').read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(['checkpoint', *build_map.RESULTS])


def test_what_was_half_written_is_removed_and_nothing_else(tmp_path):
    Checkpoint(tmp_path, {'survey': 1}).save_step('linked')
    for name in ('.images.bin.x1y2x1y2', '.dots_00001.npz.ab_cd_ef', '.submaps_00000.npz.abcd_123', '.linked.npz.swp'):
        (tmp_path / name).write_bytes(b'half')
    Checkpoint(tmp_path, {'survey': 1})
    assert sorted(path.name for path in tmp_path.iterdir()) == ['.linked.npz.swp', 'linked.npz', 'survey.json']


def test_a_full_disk_is_reported_and_the_survey_resumes(scene, tmp_path, capsys, monkeypatch):
    saved = np.savez
    calls = []

    def full(file: object, **arrays: object) -> None:
        calls.append(1)
        if len(calls) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        saved(file, **arrays)

    monkeypatch.setattr(checkpoint.np, 'savez', full)
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path)
    assert code == 1
    assert 'No space left on device; free some and give the same command again' in fault_of(err)
    assert [path.name for path in (tmp_path / 'checkpoint').iterdir() if path.name.startswith('.')] == []
    monkeypatch.setattr('floor_localizer.survey_files.survey_run.DotDetector', no_detector)
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path)
    assert code == 0, err  # the dots were kept: no image was looked at again


def test_a_disk_that_fills_up_while_adjusting_is_reported(scene, whole, tmp_path, capsys, monkeypatch):
    with monkeypatch.context() as full:
        full.setattr(array_file, 'write_array', without_room)
        code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path / 'full')
    assert code == 1
    assert 'No space left on device; free some and give the same command again' in fault_of(err)
    # Files that a process killed here would leave.
    (tmp_path / 'full/checkpoint/adjustment/run').mkdir(parents=True, exist_ok=True)
    (tmp_path / 'full/checkpoint/adjustment/run/block_00000.npy').write_bytes(b'half')
    monkeypatch.setattr('floor_localizer.survey_files.survey_run.DotDetector', no_detector)
    assert run(capsys, *folder_options(scene), '--out', tmp_path / 'full')[0] == 0
    assert (tmp_path / 'full/map.csv').read_bytes() == (whole / 'map.csv').read_bytes()
    assert not (tmp_path / 'full/checkpoint/adjustment').exists()


def begun(scene: Path, folder: Path, workers: int) -> subprocess.Popen[str]:
    """Start a survey on workers and wait until it has written the dots of an image."""
    # A process that a shell started in the background ignores interrupts, and so would its children.
    command = ['env', '--default-signal=INT', sys.executable, '-m', 'floor_localizer.commands.build_map']
    child = subprocess.Popen(
        [*command, *map(str, folder_options(scene)), '--out', str(folder), *FLAGS, '--workers', str(workers)],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    deadline = time.monotonic() + 90.0
    while not (folder / 'checkpoint/dots_00000.npz').exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    return child


def test_a_survey_killed_while_finding_dots_goes_on_and_ends_the_same(scene, whole, tmp_path, capsys):
    with begun(scene, tmp_path / 'killed', 1) as child:
        os.killpg(child.pid, signal.SIGKILL)
    assert not (tmp_path / 'killed' / 'map.csv').exists()
    code, _, err = run(capsys, *folder_options(scene), '--out', tmp_path / 'killed')
    assert code == 0, err
    assert (tmp_path / 'killed' / 'map.csv').read_bytes() == (whole / 'map.csv').read_bytes()


def test_an_interrupt_ends_a_survey_with_its_workers_in_one_line(scene, whole, tmp_path, capsys):
    with begun(scene, tmp_path, 2) as child:
        os.killpg(child.pid, signal.SIGINT)  # as a terminal does it: to all processes
        _, err = child.communicate(timeout=60.0)
    assert child.returncode == 130
    assert err == '\nbuild_map: interrupted; give the same command again to resume\n'
    assert not (tmp_path / 'map.csv').exists()
    assert run(capsys, *folder_options(scene), '--out', tmp_path)[0] == 0
    assert (tmp_path / 'map.csv').read_bytes() == (whole / 'map.csv').read_bytes()
