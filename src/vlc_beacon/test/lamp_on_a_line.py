"""Simulated lamp on a pseudo-terminal that receives requests and replies."""

import os
import pty
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def lamp_that(answers: Callable[[str], str]) -> Iterator[tuple[Path, list[str]]]:
    """Run a lamp on a pseudo-terminal; give its path and the lines that it heard."""
    master, slave = pty.openpty()
    received: list[str] = []

    def serve() -> None:
        buffer = b''
        while True:
            try:
                buffer += os.read(master, 256)
            except OSError:
                return
            while b'\r' in buffer:
                line, buffer = buffer.split(b'\r', 1)
                if line:
                    received.append(line.decode())
                    os.write(master, answers(received[-1]).encode())

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield Path(os.ttyname(slave)), received
    finally:
        os.close(slave)
        thread.join(5.0)
        os.close(master)


def usual(line: str) -> str:
    return 'led_beacon 1 508\r\n' if line == 'v' else 'OK\r\n'
