"""The firmware of the LED beacon in simavr: built, powered, spoken to, and its light recorded."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.light_code.waveform import Waveform
from vlc_beacon.core.transmitter.serial_protocol import upload_requests

FIRMWARE = Path(__file__).resolve().parents[1] / 'firmware/led_beacon'
TOOLS = ('make', 'avr-gcc', 'gcc')
HEADERS = ('/usr/include/simavr/sim_avr.h', '/usr/lib/avr/include/avr/io.h')
TICK_RATE = 16_000_000
ANSWER_US = 3_000_000
HALVES_ON = 3


def missing_tools() -> list[str]:
    """Return what lacks to build and run the firmware."""
    return [tool for tool in TOOLS if not shutil.which(tool)] + [h for h in HEADERS if not Path(h).exists()]


def build_firmware(folder: Path) -> None:
    """Build the firmware and its simulator in a folder.

    Raises:
        subprocess.CalledProcessError: the compiler has something to say.
    """
    targets = [f'{folder}/{name}' for name in ('led_beacon.hex', 'simulator')]
    environment = {k: v for k, v in os.environ.items() if k not in ('MAKEFLAGS', 'MAKELEVEL')}
    make = ['make', '-s', '-C', str(FIRMWARE), f'BUILD={folder}', *targets]
    subprocess.run(make, check=True, capture_output=True, text=True, env=environment)


class SimulatedLamp:
    """A lamp from power on to power off; its EEPROM lasts.

    Args:
        build: folder of `build_firmware`.
        eeprom: file of its EEPROM; it need not exist.
    """

    def __init__(self, build: Path, eeprom: Path) -> None:
        self._pins = eeprom.with_suffix('.vcd')
        command = [build / 'simulator', build / 'led_beacon.elf', eeprom, self._pins]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def send(self, data: bytes) -> None:
        """Send bytes that are not waited for."""
        self._command(f's {data.hex()}')

    def run(self, seconds: float) -> bytes:
        """Let time pass and return what the lamp sent."""
        self._command(f'r {round(seconds * 1e6)}')
        return self._sent()

    def ask(self, request: str) -> str:
        """Send a line and return the lamp's answer."""
        self.send(request.encode() + b'\r')
        self._command(f'l {ANSWER_US}')
        answer = self._sent().decode()
        assert answer.endswith('\r\n'), f'{request} was answered {answer!r}'
        return answer.strip()

    def load(self, frame: bytes, *, keep: bool = True) -> list[str]:
        """Send a frame and return all answers."""
        return [self.ask(request) for request in upload_requests(frame, keep=keep)]

    def power_off(self) -> Light:
        """End it and return how it shone."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        assert self._process.wait(10) == 0
        return light_of_vcd(self._pins.read_text())

    def _command(self, command: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(command + '\n')
        self._process.stdin.flush()

    def _sent(self) -> bytes:
        assert self._process.stdout is not None
        answer = self._process.stdout.readline()
        assert answer.endswith('\n'), 'the simulator died'
        return bytes.fromhex(answer)


@dataclass(frozen=True)
class Light:
    """How a lamp shone.

    Attributes:
        ticks: shape (n,), when the pins changed, of the controller's clock, from its start on.
        states: shape (n,), from then on; bit 0 is half A, bit 1 half B.
    """

    ticks: NDArray[np.int64]
    states: NDArray[np.int64]

    def waveform(self, start: int, period: float, periods: int) -> Waveform:
        """Return whole periods [ticks] of it as a waveform."""
        end = start + round(periods * period)
        inside = (self.ticks > start) & (self.ticks < end)
        first = int(self.states[np.searchsorted(self.ticks, start, side='right') - 1])
        states = np.append(first, self.states[inside])
        times = np.append(0, self.ticks[inside] - start) / TICK_RATE
        assert self.ticks[-1] >= end, 'not recorded for so long'
        return Waveform(times, (states[:, None] >> np.arange(2) & 1).astype(float), periods * period / TICK_RATE)


def light_of_vcd(text: str) -> Light:
    """Return what a value change dump of pins `half_a` and `half_b` recorded."""
    head, _, body = text.partition('$enddefinitions $end')
    bit_of_alias = {}
    scale = 0.0
    for line in head.splitlines():
        words = line.split()
        if words[:1] == ['$timescale']:
            number = words[1].rstrip('npus')
            scale = int(number) * {'ns': 1e-9, 'us': 1e-6, 'ps': 1e-12}[words[1][len(number) :]]
        elif words[:1] == ['$var']:
            bit_of_alias[words[3]] = ('half_a', 'half_b').index(words[4])
    times, states, state = [0], [0], 0
    for line in body.split('$end', 1)[1].splitlines():
        if line.startswith('#'):
            times.append(round(int(line[1:]) * scale * TICK_RATE))
            states.append(state)
        elif line:
            bit = 1 << bit_of_alias[line[1:]]
            state = state | bit if line[0] == '1' else state & ~bit
            states[-1] = state
    ticks, values = np.array(times), np.array(states)
    # Both pins change at one tick, though the dump may tell them one after the other.
    last = np.append(ticks[1:] != ticks[:-1], True)
    ticks, values = ticks[last], values[last]
    changed = np.append(True, values[1:] != values[:-1])
    return Light(ticks[changed], values[changed])
