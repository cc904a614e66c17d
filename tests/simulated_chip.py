"""Builds a firmware, runs it in simavr and communicates over its serial line."""

import os
import shutil
import subprocess
from pathlib import Path
from typing import Self

FIRMWARE = Path(__file__).resolve().parents[1] / 'firmware'
TOOLS = ('make', 'avr-gcc', 'gcc')
HEADERS = ('/usr/include/simavr/sim_avr.h', '/usr/lib/avr/include/avr/io.h')
ANSWER_US = 3_000_000


def missing_tools() -> list[str]:
    """Return what lacks to build and run a firmware."""
    return [tool for tool in TOOLS if not shutil.which(tool)] + [h for h in HEADERS if not Path(h).exists()]


def build_firmware(sketch: str, folder: Path) -> None:
    """Build a firmware and its simulator in a folder."""
    targets = [f'{folder}/{name}' for name in (f'{sketch}.hex', 'simulator')]
    environment = {k: v for k, v in os.environ.items() if k not in ('MAKEFLAGS', 'MAKELEVEL')}
    make = ['make', '-s', '-C', str(FIRMWARE / sketch), f'BUILD={folder}', *targets]
    built = subprocess.run(make, check=False, capture_output=True, text=True, env=environment)
    assert built.returncode == 0, built.stderr


class SimulatedChip:
    """A controller from power on to power off, in simulated time.

    Args:
        build: folder of `build_firmware`.
        arguments: of its simulator.
    """

    def __init__(self, build: Path, *arguments: Path) -> None:
        command = [build / 'simulator', *arguments]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def send(self, data: bytes) -> None:
        """Send bytes that are not waited for."""
        self._command(f's {data.hex()}')

    def run(self, seconds: float) -> bytes:
        """Let time pass and return what the controller sent."""
        self._command(f'r {round(seconds * 1e6)}')
        return self._sent()

    def ask(self, request: str) -> str:
        """Send a line and return the controller's answer."""
        self.send(request.encode() + b'\r')
        self._command(f'l {ANSWER_US}')
        answer = self._sent().decode()
        assert answer.endswith('\r\n'), f'{request}: unexpected reply {answer!r}'
        return answer.strip()

    def end(self) -> None:
        """Power off, if it is on."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        assert self._process.wait(10) == 0

    def _command(self, command: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(command + '\n')
        self._process.stdin.flush()

    def _answer(self) -> str:
        assert self._process.stdout is not None
        answer = self._process.stdout.readline()
        assert answer.endswith('\n'), 'the simulator exited'
        return answer

    def _sent(self) -> bytes:
        return bytes.fromhex(self._answer())
