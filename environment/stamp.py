"""The stamp of an environment: a file whose lines say what it was made from, written when it is complete."""

import hashlib
from pathlib import Path

STAMP = 'shirube.stamp'


def lock_line(lock: Path) -> str:
    """Return the stamp's line for a lock file, as sha256sum prints it."""
    return f'{hashlib.sha256(lock.read_bytes()).hexdigest()}  {lock.name}'


def read_stamp(folder: Path) -> list[str]:
    """Return the lines of the stamp: what the environment was made from; none if it was never finished."""
    try:
        return (folder / STAMP).read_text(encoding='utf-8', errors='surrogateescape').splitlines()
    except FileNotFoundError:
        return []


def write_stamp(folder: Path, lines: list[str]) -> None:
    """Write what the environment was made from, in one step.

    Raises:
        OSError: it cannot be written.
    """
    draft = folder / f'{STAMP}.new'
    draft.write_text('\n'.join(lines) + '\n', encoding='utf-8', errors='surrogateescape')
    draft.rename(folder / STAMP)


def remove_stamp(folder: Path) -> None:
    """Mark the environment as unfinished."""
    (folder / STAMP).unlink(missing_ok=True)
