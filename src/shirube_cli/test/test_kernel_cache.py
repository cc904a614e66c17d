"""The loops of all packages are compiled, and machine code of other sources goes."""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from shirube_cli.kernel_cache import (
    PROGRAMS,
    PROLOGUE,
    PYTHON,
    digest_loops,
    fresh_cache,
    put_beside_installed,
)

pytestmark = pytest.mark.newest_set_only

SOURCES = Path(__file__).resolve().parents[2]


def test_the_warm_ups_of_all_packages_are_run_once() -> None:
    modules = {
        '.'.join(path.relative_to(package).with_suffix('').parts)
        for package in SOURCES.iterdir()
        for path in package.glob(f'{package.name}/**/warm_up.py')
    }
    run = [
        line.split()[1] for program in PROGRAMS for line in program.splitlines() if line.startswith('from')
    ]
    assert sorted(run) == sorted(modules)
    assert all(program.count('warm_up()') == program.count('from ') for program in PROGRAMS)


def test_ctrl_c_ends_a_compiler_without_a_word() -> None:
    program = f'{PROLOGUE}\nimport time\nprint("ready", flush=True)\ntime.sleep(60.0)'
    compiler = subprocess.Popen(
        [sys.executable, '-c', program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert compiler.stdout is not None
    assert compiler.stdout.readline() == 'ready\n'
    compiler.send_signal(signal.SIGINT)
    assert compiler.communicate(timeout=20) == ('', '')
    assert compiler.returncode == -signal.SIGINT


def test_only_the_cache_of_these_sources_stays(tmp_path: Path) -> None:
    for name in ('0' * 16, '1' * 16):
        (tmp_path / name).mkdir()
    cache = fresh_cache(tmp_path, '1' * 64)
    assert cache == tmp_path / ('1' * 16)
    assert sorted(tmp_path.iterdir()) == [cache]


def test_the_digest_sees_loops_and_what_goes_into_them_and_nothing_else(tmp_path: Path) -> None:
    package = tmp_path / 'robot' / 'robot'
    package.mkdir(parents=True)
    files = {
        'loops.py': 'from robot.constants import REACH\n\n\n@njit(cache=True)\ndef reach():\n    return REACH\n',
        'constants.py': 'REACH = 1\n',
        'words.py': 'HELLO = 1\n',
    }
    digests = []
    for changed in (None, *files):
        for name, text in files.items():
            (package / name).write_text(text + '# changed\n' * (name == changed))
        digests.append(digest_loops(tmp_path))
    untouched, loops, constants, words = digests
    assert words == untouched
    assert len({untouched, loops, constants}) == 3


LOOP = 'from numba import njit\n\n\n@njit(cache=True)\ndef twice(x):\n    return 2 * x\n'


def source_and_copy(root: Path) -> tuple[Path, Path]:
    """Write a package with a loop and a copy as colcon installs it."""
    source = root / 'src' / 'probe'
    (source / 'probe').mkdir(parents=True)
    (source / 'probe' / 'loops.py').write_text(LOOP)
    installed = root / 'ros2_ws' / 'install' / 'probe' / 'lib' / PYTHON / 'site-packages'
    shutil.copytree(source, installed)
    return source, installed


def call_the_loop(packages: Path, **environment: str) -> str:
    """Import the loop from a folder of packages, call it, and return what numba says of its cache."""
    command = [sys.executable, '-c', 'from probe.loops import twice; twice(1)']
    known = {name: value for name, value in os.environ.items() if name != 'NUMBA_CACHE_DIR'}
    wanted = {**known, 'PYTHONPATH': str(packages), 'NUMBA_DEBUG_CACHE': '1', **environment}
    return subprocess.run(command, env=wanted, check=True, capture_output=True, text=True).stdout


def test_what_is_installed_uses_the_machine_code_of_its_source(tmp_path: Path) -> None:
    source, installed = source_and_copy(tmp_path)
    assert 'data saved' in call_the_loop(source, NUMBA_CACHE_DIR=str(tmp_path / 'cache'))
    put_beside_installed(tmp_path / 'cache', tmp_path)
    said = call_the_loop(installed)
    assert 'data loaded' in said
    assert 'saved' not in said


def test_a_copy_of_another_state_gets_no_machine_code(tmp_path: Path) -> None:
    source, installed = source_and_copy(tmp_path)
    call_the_loop(source, NUMBA_CACHE_DIR=str(tmp_path / 'cache'))
    (installed / 'probe' / 'loops.py').write_text(LOOP.replace('2', '3'))
    put_beside_installed(tmp_path / 'cache', tmp_path)
    assert not list(installed.rglob('*.nb[ic]'))
