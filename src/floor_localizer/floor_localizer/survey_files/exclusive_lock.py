"""Lock a folder for one survey at a time; two surveys would remove each other's files."""

from __future__ import annotations

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from floor_localizer.core.errors import FloorLocalizerError


@contextmanager
def exclusive_lock(folder: Path) -> Iterator[None]:
    """Create a folder and lock it against other surveys; the lock of a killed process is released.

    Raises:
        FloorLocalizerError: another survey is running there.
        OSError: the folder cannot be written to.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / 'lock').open('ab') as file:  # network file systems can lock only files opened for writing
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as fault:
            raise FloorLocalizerError(
                f'{folder}: another survey is running there; wait for its end or choose another --out'
            ) from fault
        yield
