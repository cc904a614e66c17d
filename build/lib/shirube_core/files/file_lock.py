"""An exclusive lock between processes."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


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
