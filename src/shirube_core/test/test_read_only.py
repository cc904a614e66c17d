"""Kernels and logs on a robot whose home and installation are read-only."""

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.newest_set_only

PACKAGE = """
from shirube_core.read_only import ensure_numba_cache

ensure_numba_cache(__file__)

from numba import njit


@njit(cache=True)
def double(x):
    return 2 * x


print(double(2))
"""


def run(folder: Path, *, home: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Import a package with a kernel whose folder cannot hold a cache: permissions do not stop root."""
    package = folder / 'hall'
    package.mkdir(exist_ok=True)
    (package / '__init__.py').write_text(PACKAGE)
    (package / '__pycache__').touch()
    (folder / 'tmp').mkdir(exist_ok=True)
    left_out = ('NUMBA_CACHE_DIR', 'XDG_CACHE_HOME')
    known = {name: value for name, value in os.environ.items() if name not in left_out}
    known |= {'HOME': home, 'TMPDIR': str(folder / 'tmp')} | environment
    return subprocess.run(
        [sys.executable, '-B', '-c', 'import hall'], env=known, cwd=folder, capture_output=True, text=True, check=False
    )


def test_without_a_writable_folder_kernels_go_to_a_private_temporary_one_with_a_warning(tmp_path: Path) -> None:
    for _ in range(2):
        done = run(tmp_path, home='/proc/none', NUMBA_CACHE_DIR='/proc/none')
        assert (done.returncode, done.stdout) == (0, '4\n'), done.stderr
        (line,) = done.stderr.splitlines()
        assert line.endswith('set NUMBA_CACHE_DIR to a writable folder')
    (cache,) = (tmp_path / 'tmp').iterdir()
    assert stat.S_IMODE(cache.stat().st_mode) == 0o700
    assert [*cache.rglob('*.nbi')]


def test_a_folder_that_others_can_write_to_is_not_used(tmp_path: Path) -> None:
    planted = tmp_path / 'tmp' / f'shirube-numba-{os.getuid()}'
    planted.mkdir(parents=True)
    planted.chmod(0o777)
    assert run(tmp_path, home='/proc/none').returncode == 0
    assert not [*planted.iterdir()]


def test_a_writable_home_is_used_as_ever(tmp_path: Path) -> None:
    done = run(tmp_path, home=str(tmp_path))
    assert (done.returncode, done.stdout, done.stderr) == (0, '4\n', '')
    assert [*(tmp_path / '.cache/numba').rglob('*.nbi')]
