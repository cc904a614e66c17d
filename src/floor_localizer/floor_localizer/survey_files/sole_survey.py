"""One survey at a time in a folder: two would remove each other's files."""

from __future__ import annotations

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from floor_localizer.core.floor_localizer_error import FloorLocalizerError


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Make a folder, and let no other survey begin there meanwhile; a process that is killed lets go of it.

    Raises:
        FloorLocalizerError: another survey is at work there.
        OSError: the place cannot be written to.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / 'lock').open('ab') as file:  # network file systems lock only what can be written to
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as fault:
            raise FloorLocalizerError(
                f'{folder}: another survey is at work there; wait for its end or choose another --out'
            ) from fault
        yield
