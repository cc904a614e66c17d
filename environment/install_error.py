"""One line for each cause that stops an installation: what is wrong, and what to do."""

import errno
import os
import signal
from collections.abc import Sequence
from pathlib import Path

FULL_DISK = ('No space left on device', 'Disk quota exceeded', 'os error 28', 'os error 122')
NO_NETWORK = (
    'Could not find a version',
    'error sending request',
    'Failed to fetch',
    'Failed to download',
    'Connection',
    'timed out',
    'dns error',
    'Network',
)


class InstallError(RuntimeError):
    """The environment could not be made; the message is one line with the remedy."""


def explain_failure(name: str, code: int, output: Sequence[str], folder: Path) -> str:
    """Return what stopped an installer.

    Args:
        name: the installer.
        code: its exit code, negative when a signal ended it.
        output: its lines.
        folder: the environment.
    """
    text = '\n'.join(output)
    if any(words in text for words in FULL_DISK):
        return f'the disk is full: {name} could not write {folder} or its cache; free some space and try again'
    if code < 0:
        return f'{name} was ended by {signal_name(-code)}; the next call starts the installation again'
    if 'Hash mismatch' in text or 'DO NOT MATCH THE HASHES' in text:
        return (
            f'{name} got a package that is not the locked one ({reason(output)}); '
            'check the mirror or proxy that packages come from'
        )
    if any(words in text for words in NO_NETWORK):
        return (
            f'{name} could not download the packages ({reason(output)}); '
            "check the network and pip's settings of index and proxy, then try again"
        )
    return f'{name} failed ({reason(output)}); the next call starts the installation again'


def explain_os_error(error: OSError, root: Path) -> str:
    """Return what the operating system refused.

    Args:
        error: its answer.
        root: the repository.
    """
    path = error.filename or root
    if error.errno in {errno.ENOSPC, errno.EDQUOT}:
        return f'the disk is full: cannot write {path}; free some space and try again'
    if error.errno in {errno.EACCES, errno.EPERM, errno.EROFS}:
        return (
            f'cannot write {path} ({owner(root)}); copy the repository to a folder of your own '
            f'(cp -r {root} ~/shirube) and call ./shirube there'
        )
    return f'{path}: {error.strerror or error}; remove the cause and try again'


def owner(root: Path) -> str:
    """Return why the repository cannot be written: it belongs to another user, or is read-only."""
    return 'it belongs to another user' if root.stat().st_uid != os.geteuid() else 'it is read-only'


def reason(output: Sequence[str]) -> str:
    """Return what an installer said last, or at an error of uv its first and its innermost cause."""
    lines = [line.strip() for line in output if line.strip()]
    errors = [line for line in lines if line.lower().startswith(('error:', 'cause:'))]
    chosen = [errors[0], errors[-1]] if len(errors) > 1 else errors or lines[-1:]
    words = [line.removeprefix('error: ').removeprefix('ERROR: ').removeprefix('cause: ') for line in chosen]
    text = '; '.join(dict.fromkeys(words)) or 'without a message'
    return text.encode('ascii', 'replace').decode()[:300]


def signal_name(number: int) -> str:
    """Return the name of a signal."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f'signal {number}'
