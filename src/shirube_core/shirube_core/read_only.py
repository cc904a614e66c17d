"""Folders for compiled kernels and logs where the installation and the home are read-only.

numba refuses to define a cached kernel, and rcl to start, without a folder that they can write to.
"""

import os
import stat
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path


def ensure_numba_cache(package_file: str) -> None:
    """Set NUMBA_CACHE_DIR to a temporary folder if numba can write to none of its own; called before it is imported.

    Args:
        package_file: ``__file__`` of the package with the kernels.
    """
    home = os.environ.get('XDG_CACHE_HOME') or '~/.cache'
    own = [os.environ.get('NUMBA_CACHE_DIR', ''), str(Path(package_file).parent / '__pycache__'), f'{home}/numba']
    if not _is_any_writable(own):
        _use_temporary('NUMBA_CACHE_DIR', 'numba', 'compiled kernels are lost when /tmp is cleared')
        if 'numba' in sys.modules:
            sys.modules['numba'].config.CACHE_DIR = os.environ['NUMBA_CACHE_DIR']


def ensure_log_folder() -> None:
    """Set ROS_LOG_DIR to a temporary folder if ROS cannot write to its own."""
    home = os.environ.get('ROS_HOME') or '~/.ros'
    if not _is_any_writable([os.environ.get('ROS_LOG_DIR') or f'{home}/log']):
        _use_temporary('ROS_LOG_DIR', 'log', 'log files are lost when /tmp is cleared')


def _is_any_writable(folders: Iterable[str]) -> bool:
    for folder in filter(None, folders):
        try:
            path = Path(folder).expanduser()
            path.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=path).close()
        except (OSError, RuntimeError):  # RuntimeError: there is no home
            continue
        return True
    return False


def _use_temporary(variable: str, name: str, loss: str) -> None:
    """Let a variable name a folder of this user that nobody else can write to: what numba loads is code."""
    folder = Path(tempfile.gettempdir()) / f'shirube-{name}-{os.getuid()}'
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
        is_private = stat.S_ISDIR(status.st_mode) and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
        if not is_private or status.st_uid != os.getuid():
            folder = Path(tempfile.mkdtemp(prefix=f'shirube-{name}-'))
    except FileExistsError:
        folder = Path(tempfile.mkdtemp(prefix=f'shirube-{name}-'))
    os.environ[variable] = str(folder)
    sys.stderr.write(f'warning: home and installation are read-only: {loss}; set {variable} to a writable folder\n')
