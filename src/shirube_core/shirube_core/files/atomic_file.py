"""Atomic writes: a file is either complete or unchanged."""

import csv
import fcntl
import io
import os
import stat
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO


@contextmanager
def exclusive_lock(folder: Path, *, file: str = '', wait: bool = True) -> Iterator[None]:
    """Hold an exclusive lock on a folder, which is created if it does not exist; other processes wait for it.

    Args:
        folder: the folder.
        file: name of a file in it to lock instead; network file systems lock only files opened for writing.
        wait: whether to wait for another process.

    Raises:
        BlockingIOError: another process holds the lock, without ``wait``.
        OSError: the folder cannot be created.
    """
    folder.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(folder / file, os.O_CREAT | os.O_WRONLY if file else os.O_RDONLY, 0o666)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(descriptor)


_ANY_SUFFIX = 8 * '?'
"""Pattern of the random suffix of `tempfile`."""


@contextmanager
def atomic_write(path: Path) -> Iterator[BinaryIO]:
    """Open a temporary file for writing; rename it to ``path`` at the end, or remove it on an error.

    The folder is created if needed. The permissions of an existing file are kept.

    Raises:
        OSError: the file cannot be written; the error names ``path``.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        handle, name = tempfile.mkstemp(prefix=f'.{path.name}.', dir=path.parent)
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, str(path)) from fault
    temporary = Path(name)
    try:
        with os.fdopen(handle, 'wb') as file:
            yield file
        temporary.chmod(_mode_of(path))
        _rename(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def remove_temporary_files(folder: Path, names: str) -> None:
    """Remove temporary files of killed processes; no process may be writing in the folder.

    Args:
        folder: folder of the files.
        names: pattern of the file names, as in `Path.glob`.
    """
    for leftover in folder.glob(f'.{names}.{_ANY_SUFFIX}'):
        leftover.unlink(missing_ok=True)


def _rename(temporary: Path, path: Path) -> None:
    try:
        temporary.replace(path)
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, str(path)) from fault


def _mode_of(path: Path) -> int:
    """Return the permissions of a file, or the default ones for a new file (mkstemp makes private files)."""
    try:
        return stat.S_IMODE(path.stat().st_mode)
    except FileNotFoundError:
        umask = os.umask(0)
        os.umask(umask)
        return 0o666 & ~umask


def write_text(path: Path | str, text: str) -> None:
    """Write a UTF-8 text file atomically."""
    with atomic_write(Path(path)) as file:
        file.write(text.encode())


def write_csv(path: Path | str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV file with a header atomically."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator='\n')
    table.writerow(columns)
    table.writerows(rows)
    write_text(path, text.getvalue())
