"""Simulated lamp on a pseudo-terminal that receives requests and replies."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from simulated_terminal import terminal_of


class AnsweringLamp:
    """Remembers the lines that it heard, and replies to each."""

    def __init__(self, answers: Callable[[str], str]) -> None:
        self.received: list[str] = []
        self._answers, self._incoming, self._outgoing = answers, b'', b''

    def send(self, data: bytes) -> None:
        *lines, self._incoming = (self._incoming + data).split(b'\r')
        for line in filter(None, lines):
            self.received.append(line.decode())
            self._outgoing += self._answers(self.received[-1]).encode()

    def run(self, _: float) -> bytes:
        outgoing, self._outgoing = self._outgoing, b''
        return outgoing


@contextmanager
def lamp_that(answers: Callable[[str], str]) -> Iterator[tuple[Path, list[str]]]:
    """Run a lamp on a pseudo-terminal; give its path and the lines that it heard."""
    lamp = AnsweringLamp(answers)
    with terminal_of(lamp) as path:
        yield path, lamp.received


def usual(line: str) -> str:
    return 'led_beacon 1 508\r\n' if line == 'v' else 'OK\r\n'
