"""Faults of a serial line and of the controller at its end, on command."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motor_bridge.core.motor_bridge_error import MotorBridgeError

FAULTS = ('silence', 'hang', 'garbage', 'wrong', 'lost_cr', 'reset', 'unplug')
"""silence S, hang S, unplug S: for so many seconds; garbage N, wrong N, lost_cr N: the next N; reset."""
_TIMED = ('silence', 'hang', 'unplug')


@dataclass(frozen=True)
class FaultOrder:
    """A fault that somebody wants.

    Attributes:
        kind: one of FAULTS.
        amount: seconds, or number of replies or commands.
    """

    kind: str
    amount: float


def read_fault_order(line: str) -> FaultOrder:
    """Return what a line such as ``silence 1.5`` orders.

    Raises:
        MotorBridgeError: there is no such fault, or its amount is no number above 0.
    """
    kind, _, amount = line.strip().partition(' ')
    if kind not in FAULTS:
        raise MotorBridgeError(f'there is no fault {kind!r}; choose one of {", ".join(FAULTS)}')
    try:
        number = float(amount or 1.0)
    except ValueError:
        number = 0.0
    if not 0.0 < number < 1e6:
        raise MotorBridgeError(f'{kind} {amount}: give a number above 0 behind the fault')
    return FaultOrder(kind, number)


class LineFaults:
    """Spoils what goes over the line, as ordered."""

    def __init__(self, rng: np.random.Generator) -> None:
        """Spoil nothing at first."""
        self._rng = rng
        self._left: dict[str, float] = dict.fromkeys(FAULTS, 0.0)

    def order(self, order: FaultOrder) -> None:
        """Let a fault happen from now on."""
        self._left[order.kind] = order.amount

    def pass_time(self, elapsed: float) -> None:
        """Let faults that last for a time end [s]."""
        for kind in _TIMED:
            self._left[kind] = max(0.0, self._left[kind] - elapsed)

    def is_on(self, kind: str) -> bool:
        """Return whether a fault has not ended."""
        return self._left[kind] > 0.0

    def take(self, kind: str) -> bool:
        """Return whether a fault strikes now; it strikes once less from now on."""
        if self._left[kind] < 1.0:
            return False
        self._left[kind] -= 1.0
        return True

    def to_controller(self, data: bytes) -> bytes:
        """Return what arrives at the controller."""
        kept = bytearray()
        for byte in data:
            if byte != 0x0D or not self.take('lost_cr'):
                kept.append(byte)
        return bytes(kept)

    def to_host(self, reply: bytes) -> bytes:
        """Return what arrives at the host of a reply that the controller sent."""
        if not reply or self.is_on('silence'):
            return b''
        if self.take('garbage'):
            return self._rng.bytes(int(self._rng.integers(1, 40)))
        if reply[:1].isdigit() or reply[:1] == b'-':
            return self._wrong_counts(reply) if self.take('wrong') else reply
        return reply

    def _wrong_counts(self, reply: bytes) -> bytes:
        """Return a well-formed reply in which one digit is another one."""
        digits = [place for place, byte in enumerate(reply) if chr(byte).isdigit()]
        spoilt = bytearray(reply)
        place = int(self._rng.choice(digits))
        spoilt[place] = 0x30 + (spoilt[place] - 0x30 + int(self._rng.integers(1, 10))) % 10
        return bytes(spoilt)
