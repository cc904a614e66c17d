"""A simulated controller on a pseudo-terminal, for programs that open a serial port."""

import os
import pty
import select
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol


class Chip(Protocol):
    """A controller that is sent bytes, and gives those that it sends in a time [s]."""

    def send(self, data: bytes) -> None: ...

    def run(self, seconds: float) -> bytes: ...


@contextmanager
def terminal_of(chip: Chip) -> Iterator[Path]:
    """Connect a controller to a pseudo-terminal; time passes there as fast as the machine can."""
    master, slave = pty.openpty()
    over = threading.Event()

    def serve() -> None:
        while not over.is_set():
            if select.select([master], [], [], 0.001)[0]:
                chip.send(os.read(master, 256))
            os.write(master, chip.run(0.02))

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield Path(os.ttyname(slave))
    finally:
        over.set()
        thread.join()
        os.close(master)
        os.close(slave)
