"""Where the repository or the installed product is, and how tools and child processes are started."""

import os
import signal
import subprocess
import sys
import sysconfig
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

GRACE = 10.0


@contextmanager
def child_process(
    command: Sequence[str], environment: Mapping[str, str], log: Path | None
) -> Iterator[subprocess.Popen[bytes]]:
    """Run a command while the block runs, and end it with SIGINT at the end of the block; the log takes its output."""
    output = None if log is None else log.open('wb')
    child = subprocess.Popen(
        command,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=output,
        stderr=None if output is None else subprocess.STDOUT,
        start_new_session=True,
    )
    try:
        yield child
    finally:
        interrupt(child)
        if output is not None:
            output.close()


def interrupt(child: subprocess.Popen[bytes]) -> int:
    """End a child as Ctrl-C does, harder when it does not listen, and return its exit code."""
    if child.poll() is None:
        child.send_signal(signal.SIGINT)
    try:
        return child.wait(GRACE)
    except subprocess.TimeoutExpired:
        child.kill()
        return child.wait()


class CommandError(RuntimeError):
    """A request that cannot be fulfilled; the message is one line that names the remedy."""


def find_home() -> Path:
    """Return the repository of this package, or what pip installed beside it; raise a CommandError if it is missing."""
    root = Path(__file__).resolve().parents[3]
    if is_clone(root):
        return root
    scheme = sysconfig.get_preferred_scheme('user')
    for data in (sysconfig.get_path('data'), sysconfig.get_path('data', scheme)):
        if (Path(data) / 'share' / 'shirube').is_dir():
            return Path(data) / 'share' / 'shirube'
    raise CommandError('the files of shirube in share/shirube are missing; install it again with pip')


def is_clone(home: Path) -> bool:
    """Return whether this is a clone of the repository, not the product that pip installed."""
    return (home / 'ros2_ws').is_dir()


def find_root() -> Path:
    """Return the repository that contains this package; raise a CommandError for the installed product."""
    home = find_home()
    if not is_clone(home):
        raise CommandError('this command works in a clone of the repository only; call ./shirube there')
    return home


def safe_environment() -> dict[str, str]:
    """Return the environment for children.

    DDS stays on this machine unless the caller chose otherwise, and a character that the terminal's encoding lacks
    is printed as a question mark.
    """
    encoding, _, errors = os.environ.get('PYTHONIOENCODING', '').partition(':')
    return {
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        **os.environ,
        'PYTHONIOENCODING': f'{encoding}:{errors or "replace"}',
    }


def run_tool(module: str, arguments: Sequence[str]) -> int:
    """Run a Python tool of the environment (such as ``pytest``) at the root and return its exit code."""
    command = [sys.executable, '-m', module, *arguments]
    return subprocess.run(command, cwd=find_root(), env=safe_environment(), check=False).returncode
