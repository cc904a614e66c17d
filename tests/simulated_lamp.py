"""The LED beacon firmware in simavr: serial communication and recorded light output."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from simulated_chip import SimulatedChip

from shirube_core.waveform import Waveform
from vlc_beacon.commands.encode import upload_requests
from vlc_beacon.core.transmitter.lamp_frame import frame_to_bytes
from vlc_beacon.core.transmitter.lamp_program import constant_tone_frame

TICK_RATE = 16_000_000


def tone_bytes(tone: float, plays: int = 0) -> bytes:
    """Return the frame of a tone [Hz]."""
    return frame_to_bytes(replace(constant_tone_frame(tone), plays=plays))


TONE = tone_bytes(2000.0)


def status_of(frame: bytes, state: str = 'playing kept', pending: int = 0) -> str:
    """Return what a lamp says of itself that has a frame."""
    return f'{state} {len(frame)} {frame[-2:].hex()} {pending}'


class SimulatedLamp(SimulatedChip):
    """A lamp from power on to power off; its EEPROM lasts.

    Args:
        build: folder of `build_firmware`.
        eeprom: file of its EEPROM; it need not exist.
    """

    def __init__(self, build: Path, eeprom: Path) -> None:
        self._pins = eeprom.with_suffix('.vcd')
        super().__init__(build, build / 'led_beacon.elf', eeprom, self._pins)

    def write_eeprom(self, count: int) -> None:
        """Let time pass until so many bytes of the EEPROM have been written, or a second."""
        self._command(f'e {count}')
        self._sent()

    def load(self, frame: bytes, *, keep: bool = True) -> list[str]:
        """Send a frame and return all answers."""
        return [self.ask(request) for request in upload_requests(frame, keep=keep)]

    def power_off(self) -> Light:
        """End it and return how it shone."""
        self.end()
        return light_of_vcd(self._pins.read_text())


@dataclass(frozen=True)
class Light:
    """How a lamp shone.

    Attributes:
        ticks: shape (n,), when the pins changed, of the controller's clock, from its start on.
        states: shape (n,), from then on; bit 0 is half A, bit 1 half B.
        preparation: longest time from a change to the end of the interrupt that prepares the next one [ticks].
    """

    ticks: NDArray[np.int64]
    states: NDArray[np.int64]
    preparation: int

    def waveform(self, start: int, period: float, periods: int) -> Waveform:
        """Return whole periods [ticks] of it as a waveform."""
        end = start + round(periods * period)
        assert self.ticks[-1] >= end - period, 'the recording is too short'
        inside = (self.ticks > start) & (self.ticks < end)
        first = int(self.states[np.searchsorted(self.ticks, start, side='right') - 1])
        states = np.append(first, self.states[inside])
        times = np.append(0, self.ticks[inside] - start) / TICK_RATE
        return Waveform(times, (states[:, None] >> np.arange(2) & 1).astype(float), periods * period / TICK_RATE)

    def first_dark(self) -> int:
        """Return when it first changed after shining steadily, at which every code's first blink ends [ticks]."""
        return int(self.ticks[2])

    def tones(self) -> list[int]:
        """Return the tones that were played one after the other, to 100 Hz, steady light left out."""
        steps = np.diff(self.ticks[2:])
        tones = np.round(0.5 * TICK_RATE / steps[steps < TICK_RATE // 1000], -2).astype(int).tolist()
        return [tone for i, tone in enumerate(tones) if i == 0 or tone != tones[i - 1]]


def light_of_vcd(text: str) -> Light:
    """Return what the simulator's value change dump recorded."""
    signals = _signals_of_vcd(text)
    ticks = np.unique(np.concatenate([signals['half_a'][0], signals['half_b'][0]]))
    half_a, half_b = (
        levels[np.searchsorted(changes, ticks, side='right') - 1]
        for changes, levels in (signals['half_a'], signals['half_b'])
    )
    states = half_a | half_b << 1
    changed = np.append(True, states[1:] != states[:-1])
    busy, running = signals['preparing']
    ends = busy[running == 0]
    ticks, states = ticks[changed], states[changed]
    begins = ticks[2:][ticks[2:] < ends.max(initial=0)]
    preparation = ends[np.searchsorted(ends, begins, side='right')] - begins
    return Light(ticks, states, int(preparation.max(initial=0)))


def _signals_of_vcd(text: str) -> dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Return times [ticks] and values of each signal, unknown ones as 0."""
    head, _, body = text.partition('$enddefinitions $end')
    words = [line.split() for line in head.splitlines()]
    name_of_alias = {w[3]: w[4] for w in words if w[:1] == ['$var']}
    unit = next(w[1] for w in words if w[:1] == ['$timescale'])
    assert unit.endswith('ps')
    ticks_of_unit = float(unit[:-2]) * 1e-12 * TICK_RATE
    changes: dict[str, dict[int, int]] = {name: {0: 0} for name in name_of_alias.values()}
    now = 0
    for line in body.partition('$end')[2].split():
        if line[0] == '#':
            now = round(int(line[1:]) * ticks_of_unit)
        else:
            changes[name_of_alias[line[1:]]][now] = int(line[0] == '1')
    return {name: (np.array(list(c)), np.array(list(c.values()))) for name, c in changes.items()}
