"""The kernels of all packages are compiled, and machine code of other sources is removed."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from shirube_cli import kernel_cache
from shirube_cli.kernel_cache import (
    PROLOGUE,
    PYTHON,
    are_installed,
    compile_sets,
    compiled_kernels,
    copy_to_installed,
    digest_kernels,
    fresh_cache,
)
from shirube_cli.kernel_registry import DEMO_SETS, KERNEL_SETS, KernelSet, sets_of_package
from shirube_cli.project import CommandError, safe_environment

pytestmark = pytest.mark.newest_set_only

SOURCES = Path(__file__).resolve().parents[2]


def test_the_registry_names_every_compile_function() -> None:
    modules = {
        '.'.join(path.relative_to(package).with_suffix('').parts)
        for package in SOURCES.iterdir()
        for path in package.glob(f'{package.name}/**/*.py')
        if re.search(r'^def compile_(default_)?kernels\(', path.read_text(), re.MULTILINE)
    }
    assert {one.module for one in KERNEL_SETS} == modules
    assert len({one.name for one in KERNEL_SETS}) == len(KERNEL_SETS)
    assert KERNEL_SETS[: len(DEMO_SETS)] == DEMO_SETS


def test_the_total_of_kernels_fits_the_sources() -> None:
    for package in {one.package for one in KERNEL_SETS}:
        folder = SOURCES / package.replace('shirube_bringup', 'scene_simulator')
        written = sum(
            path.read_text().count('\n@njit') for path in folder.glob('*/**/*.py') if 'test' not in path.parts
        )
        counted = sum(one.kernels for one in KERNEL_SETS if one.package == package)
        assert written // 2 < counted <= written, package


def test_a_package_needs_its_own_kernels_and_those_of_what_it_imports() -> None:
    root = SOURCES.parent
    assert [one.name for one in sets_of_package(root, 'floor_localizer')] == ['floor_localizer']
    assert sets_of_package(root, 'shirube_bags') == ()
    assert set(DEMO_SETS) <= set(sets_of_package(root, 'shirube_bringup'))
    assert sets_of_package(root, 'nothing') == ()


def test_only_missing_sets_are_compiled_and_a_killed_compiler_leaves_no_mark(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiled: list[str] = []
    failing = ['stereo_landmark']

    def fake_compile(sets, _environment, finish):
        for one in sets:
            if one.name in failing:
                raise CommandError
            compiled.append(one.name)
            finish(one)

    cache = tmp_path / 'numba' / 'digest'
    monkeypatch.setattr(kernel_cache, 'kernel_folder', lambda _: cache)
    monkeypatch.setattr(kernel_cache, 'compile_sets', fake_compile)
    with pytest.raises(CommandError):
        compiled_kernels(tmp_path, DEMO_SETS)
    assert compiled == ['floor_localizer']
    failing.clear()
    assert compiled_kernels(tmp_path) == cache
    assert sorted(compiled) == sorted(one.name for one in KERNEL_SETS)


THREE_KERNELS = 'import sys\nfor _ in sys.stdin: print("kernel\\n" * 3 + "done", flush=True)'


def test_progress_is_plain_lines_that_count_to_the_total(capfd: pytest.CaptureFixture[str]) -> None:
    done: list[KernelSet] = []
    sets = [KernelSet(name, 'probe', 'none', 5) for name in ('first', 'second', 'third')]
    compile_sets(sets, safe_environment(), done.append, THREE_KERNELS)
    assert sorted(done, key=lambda one: one.name) == sets
    lines = capfd.readouterr().err.splitlines()
    assert lines[0] == 'Compiling kernels (once): 0 of 15'
    assert lines[-1] == 'Compiling kernels (once): 15 of 15'


@pytest.mark.parametrize('program', ['', 'input(); exit(1)', 'import os; os.kill(os.getpid(), 9)'])
def test_compiler_that_ends_early_is_one_line(program: str) -> None:
    with pytest.raises(CommandError, match=r'could not be compiled, see above; .* try again'):
        compile_sets([KERNEL_SETS[0]], safe_environment(), lambda _: None, program)


def test_ctrl_c_ends_a_compiler_without_output() -> None:
    program = f'{PROLOGUE}\nimport time\nprint("ready", flush=True)\ntime.sleep(60.0)'
    pipes = {'stdout': subprocess.PIPE, 'stderr': subprocess.PIPE, 'text': True}
    compiler = subprocess.Popen([sys.executable, '-c', program], **pipes)
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


def test_the_digest_sees_kernels_and_what_goes_into_them_and_nothing_else(tmp_path: Path) -> None:
    package = tmp_path / 'robot' / 'robot'
    package.mkdir(parents=True)
    files = {
        'kernels.py': 'from robot.constants import REACH\n@njit(cache=True)\ndef reach():\n    return REACH\n',
        'constants.py': 'REACH = 1\n',
        'words.py': 'HELLO = 1\n',
    }
    digests = []
    for changed in (None, *files):
        for name, text in files.items():
            (package / name).write_text(text + '# changed\n' * (name == changed))
        digests.append(digest_kernels({'robot': package}))
    untouched, kernels, constants, words = digests
    assert words == untouched
    assert len({untouched, kernels, constants}) == 3


KERNEL = 'from numba import njit\n\n\n@njit(cache=True)\ndef twice(x):\n    return 2 * x\n'


def source_and_copy(root: Path) -> tuple[Path, Path]:
    """Write a package with a kernel and a copy as colcon installs it."""
    source = root / 'src' / 'probe'
    (source / 'probe').mkdir(parents=True)
    (source / 'probe' / 'kernels.py').write_text(KERNEL)
    installed = root / 'ros2_ws' / 'install' / 'probe' / 'lib' / PYTHON / 'site-packages'
    shutil.copytree(source, installed)
    return source, installed


def call_the_kernel(packages: Path, **environment: str) -> str:
    """Import the kernel from a folder of packages, call it, and return what numba says of its cache."""
    command = [sys.executable, '-c', 'from probe.kernels import twice; twice(1)']
    known = {name: value for name, value in os.environ.items() if name != 'NUMBA_CACHE_DIR'}
    wanted = {**known, 'PYTHONPATH': str(packages), 'NUMBA_DEBUG_CACHE': '1', **environment}
    return subprocess.run(command, env=wanted, check=True, capture_output=True, text=True).stdout


def test_what_is_installed_uses_the_machine_code_of_its_source_and_another_state_gets_none(tmp_path: Path) -> None:
    source, installed = source_and_copy(tmp_path)
    assert 'data saved' in call_the_kernel(source, NUMBA_CACHE_DIR=str(tmp_path / 'cache'))
    same = (installed / 'probe' / 'kernels.py').read_text()
    (installed / 'probe' / 'kernels.py').write_text(KERNEL.replace('2', '3'))
    copy_to_installed(tmp_path / 'cache', tmp_path)
    assert not list(installed.rglob('*.nb[ic]'))
    (installed / 'probe' / 'kernels.py').write_text(same)
    copy_to_installed(tmp_path / 'cache', tmp_path)
    said = call_the_kernel(installed)
    assert 'data loaded' in said
    assert 'saved' not in said


def test_kernels_count_as_installed_after_the_copy_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache = tmp_path / 'numba' / 'digest'
    monkeypatch.setattr(kernel_cache, 'kernel_folder', lambda _: cache)
    assert are_installed(tmp_path, [])
    assert not are_installed(tmp_path, DEMO_SETS)
    copy_to_installed(cache, tmp_path, DEMO_SETS)
    assert are_installed(tmp_path, DEMO_SETS)
    assert not are_installed(tmp_path, KERNEL_SETS)
    monkeypatch.setattr(kernel_cache, 'kernel_folder', lambda _: cache.with_name('of other sources'))
    assert not are_installed(tmp_path, DEMO_SETS)
