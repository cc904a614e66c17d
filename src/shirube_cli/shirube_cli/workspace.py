"""The colcon workspace ``ros2_ws``: built when a package changed, and its overlay for processes.

``colcon build`` does not know what is up to date and needs seconds even when nothing changed, so a digest
of a package's sources is kept in its installation.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import entry_points
from pathlib import Path

from shirube_cli.kernel_cache import PYTHON, are_installed, compiled_kernels, copy_to_installed, kernel_folder
from shirube_cli.kernel_registry import KERNEL_SETS, KernelSet
from shirube_cli.project import CommandError, is_clone, safe_environment
from shirube_core.files import exclusive_lock

EXECUTABLES = 'shirube.executables'
"""Entry points that name the executables of the installed product, ``package.executable``."""


def find_packages(root: Path) -> list[str]:
    """Return the names of all packages of the workspace, or of the installed product that have executables."""
    if not is_clone(root):
        return sorted(installed_executables())
    return sorted(path.parent.name for path in (root / 'src').glob('*/package.xml'))


def installed_executables() -> dict[str, list[str]]:
    """Return the executables of the installed product by package."""
    found: dict[str, list[str]] = {}
    for point in entry_points(group=EXECUTABLES):
        package, _, name = point.name.partition('.')
        found.setdefault(package, []).append(name)
    return found


def build_workspace(root: Path, sets: Sequence[KernelSet] = KERNEL_SETS) -> None:
    """Build every package that changed since it was built last, and compile kernel sets, by default all,
    meanwhile; the installed product needs only the latter.

    Raises:
        CommandError: colcon or a compiler failed; its output was printed.
    """
    if not is_clone(root):
        compiled_kernels(root, sets)
        return
    with exclusive_lock(root / 'ros2_ws'):
        digests = {name: digest_package(root / 'src' / name) for name in find_packages(root)}
        changed = [name for name, digest in digests.items() if not _is_built(root, name, digest)]
        needed = [one for one in sets if one.package in digests]
        if not changed and are_installed(root, needed):
            return
        for name in changed:  # modules that are gone from src would stay installed otherwise
            shutil.rmtree(root / 'ros2_ws' / 'build' / name, ignore_errors=True)
            shutil.rmtree(root / 'ros2_ws' / 'install' / name, ignore_errors=True)
        with _colcon(root, changed):
            cache = compiled_kernels(root, needed) if needed else None
        if cache is not None:
            copy_to_installed(cache, root, needed)
        for name in changed:
            _stamp_path(root, name).write_text(digests[name])


def digest_package(folder: Path) -> str:
    """Return a digest of everything that a package is installed from, and of the Python that installs it."""
    digest = hashlib.sha256(PYTHON.encode())
    for parent, folders, files in os.walk(folder, followlinks=True):
        folders[:] = sorted(f for f in folders if f not in {'test', '__pycache__'} and not f.endswith('.egg-info'))
        for name in sorted(files):
            path = Path(parent, name)
            digest.update(f'\0{path.relative_to(folder)}\0{path.stat().st_mode}\0'.encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def find_executable(root: Path, package: str, executable: str) -> list[str]:
    """Return the command that ``ros2 run package executable`` would start; raise a CommandError for no such one."""
    packages = find_packages(root)
    if package not in packages:
        raise CommandError(f'there is no package {package!r}; choose one of: {", ".join(packages)}')
    folder = root / 'ros2_ws' / 'install' / package / 'lib' / package
    names = sorted(path.name for path in folder.glob('*') if path.is_file())
    if not is_clone(root):
        names = sorted(installed_executables()[package])
    if executable not in names:
        there = f'choose one of: {", ".join(names)}' if names else 'or any other'
        raise CommandError(f'package {package} has no executable {executable!r}; {there}')
    # Through the interpreter, because a first line `#!` cannot name one whose path has spaces.
    if not is_clone(root):
        return [sys.executable, '-m', 'shirube_cli.execute', package, executable]
    return [sys.executable, str(folder / executable)]


def overlay_environment(root: Path) -> dict[str, str]:
    """Return the environment that sourcing the workspace makes, with the ROS of the wheels under it."""
    if not is_clone(root):
        kernels = {'NUMBA_CACHE_DIR': str(kernel_folder(root))}
        return {**safe_environment(), **kernels, 'AMENT_PREFIX_PATH': sys.prefix}
    prefixes = [root / 'ros2_ws' / 'install' / name for name in find_packages(root)]
    environment = safe_environment()
    environment.pop('NUMBA_CACHE_DIR', None)  # installed kernels have their machine code next to them
    environment['AMENT_PREFIX_PATH'] = os.pathsep.join(map(str, [*prefixes, sys.prefix]))
    environment['PYTHONPATH'] = os.pathsep.join(str(p / 'lib' / PYTHON / 'site-packages') for p in prefixes)
    return environment


def _stamp_path(root: Path, name: str) -> Path:
    return root / 'ros2_ws' / 'install' / name / 'built_from'


def _is_built(root: Path, name: str, digest: str) -> bool:
    stamp = _stamp_path(root, name)
    return stamp.is_file() and stamp.read_text() == digest


@contextmanager
def _colcon(root: Path, packages: Sequence[str]) -> Iterator[None]:
    """Build packages while the block runs; what colcon prints goes to a file, and to stderr if it fails."""
    if not packages:
        yield
        return
    print(f"Building {len(packages)} of the workspace's packages ...", file=sys.stderr)
    command = [sys.executable, '-m', 'colcon', 'build', '--packages-select', *packages]
    command += ['--event-handlers', 'desktop_notification-', 'status-']
    # setup.py install is deprecated for everybody but colcon, whose users cannot change it.
    environment = {**safe_environment(), 'PYTHONWARNINGS': 'ignore', 'PYTHONDONTWRITEBYTECODE': ''}
    with tempfile.TemporaryFile() as output:
        build = subprocess.Popen(
            command, cwd=root / 'ros2_ws', env=environment, stdout=output, stderr=subprocess.STDOUT
        )
        try:
            yield
        finally:
            code = build.wait()
        # Colcon skips a package whose setup.py it cannot read and calls that a success.
        missing = [name for name in packages if not _stamp_path(root, name).parent.is_dir()]
        if code or missing:
            output.seek(0)
            print(output.read().decode(errors='replace'), file=sys.stderr)
            raise CommandError('colcon build failed in ros2_ws, see above')
