"""Writing of files that are either whole or not there."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

_ANY_ENDING = 8 * '?'
"""Of the names that `tempfile` gives."""


@contextmanager
def written_beside(path: Path) -> Iterator[BinaryIO]:
    """Open a file beside ``path`` for writing and rename it to ``path`` at the end, or remove it on an error.

    Its folder is made if needed. A file that stood there before keeps its permissions.

    Raises:
        OSError: the place cannot be written to; it names ``path``.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        handle, name = tempfile.mkstemp(prefix=f'.{path.name}.', dir=path.parent)
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, str(path)) from fault
    beside = Path(name)
    try:
        with os.fdopen(handle, 'wb') as file:
            yield file
        beside.chmod(_mode_of(path))
        _rename(beside, path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise


def remove_halves(folder: Path, names: str) -> None:
    """Remove what processes that were killed have left half written; nobody may be writing there.

    Args:
        folder: of the files.
        names: pattern of their names, as of `Path.glob`.
    """
    for half in folder.glob(f'.{names}.{_ANY_ENDING}'):
        half.unlink(missing_ok=True)


def _rename(beside: Path, path: Path) -> None:
    try:
        beside.replace(path)
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, str(path)) from fault


def _mode_of(path: Path) -> int:
    """Return the permissions of a file, of one that is new as any new file has them: mkstemp makes private ones."""
    try:
        return stat.S_IMODE(path.stat().st_mode)
    except FileNotFoundError:
        umask = os.umask(0)
        os.umask(umask)
        return 0o666 & ~umask


def write_text(path: Path | str, text: str) -> None:
    """Write a file of text in UTF-8, whole or not at all, as `written_beside`."""
    with written_beside(Path(path)) as file:
        file.write(text.encode())
