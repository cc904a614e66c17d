"""Child processes in a session of their own, which end with the command that started them."""

import signal
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

GRACE = 10.0


@contextmanager
def child_process(
    command: Sequence[str], environment: Mapping[str, str], log: Path | None
) -> Iterator[subprocess.Popen[bytes]]:
    """Run a command while the block runs, and end it with SIGINT at the end of the block; the log takes its
    output.
    """
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
