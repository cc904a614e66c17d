"""Fault injection on the serial line and the controller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motor_bridge.core.motor_bridge_error import MotorBridgeError

FAULTS = ('silence', 'hang', 'garbage', 'wrong', 'lost_cr', 'reset', 'unplug')
"""silence S, hang S, unplug S: for S seconds; garbage N, wrong N, lost_cr N: the next N; reset."""
_TIMED = ('silence', 'hang', 'unplug')


@dataclass(frozen=True)
class FaultOrder:
    """A fault to inject.

    Attributes:
        kind: one of FAULTS.
        amount: duration [s], or number of replies or commands.
    """

    kind: str
    amount: float


def read_fault_order(line: str) -> FaultOrder:
    """Parse a line such as ``silence 1.5``.

    Raises:
        MotorBridgeError: an unknown fault, or an amount that is not a number above 0.
    """
    kind, _, amount = line.strip().partition(' ')
    if kind not in FAULTS:
        raise MotorBridgeError(f'unknown fault {kind!r}; choose one of {", ".join(FAULTS)}')
    try:
        number = float(amount or 1.0)
    except ValueError:
        number = 0.0
    if not 0.0 < number < 1e6:
        raise MotorBridgeError(f'{kind} {amount}: give a number above 0 after the fault')
    return FaultOrder(kind, number)


class LineFaults:
    """Corrupts the data on the line."""

    def __init__(self, rng: np.random.Generator) -> None:
        """Start without faults."""
        self._rng = rng
        self._left: dict[str, float] = dict.fromkeys(FAULTS, 0.0)

    def order(self, order: FaultOrder) -> None:
        """Inject a fault."""
        self._left[order.kind] = order.amount

    def pass_time(self, elapsed: float) -> None:
        """Advance the timed faults [s]."""
        for kind in _TIMED:
            self._left[kind] = max(0.0, self._left[kind] - elapsed)

    def is_on(self, kind: str) -> bool:
        """Return whether a fault is active."""
        return self._left[kind] > 0.0

    def take(self, kind: str) -> bool:
        """Return whether a counted fault applies now, and decrement its counter."""
        if self._left[kind] < 1.0:
            return False
        self._left[kind] -= 1.0
        return True

    def to_controller(self, data: bytes) -> bytes:
        """Return the data that the controller receives."""
        kept = bytearray()
        for byte in data:
            if byte != 0x0D or not self.take('lost_cr'):
                kept.append(byte)
        return bytes(kept)

    def to_host(self, reply: bytes) -> bytes:
        """Return the reply that the host receives."""
        if not reply or self.is_on('silence'):
            return b''
        if self.take('garbage'):
            return self._rng.bytes(int(self._rng.integers(1, 40)))
        if reply[:1].isdigit() or reply[:1] == b'-':
            return self._wrong_counts(reply) if self.take('wrong') else reply
        return reply

    def _wrong_counts(self, reply: bytes) -> bytes:
        """Return a well-formed reply with one digit changed."""
        digits = [place for place, byte in enumerate(reply) if chr(byte).isdigit()]
        spoilt = bytearray(reply)
        place = int(self._rng.choice(digits))
        spoilt[place] = 0x30 + (spoilt[place] - 0x30 + int(self._rng.integers(1, 10))) % 10
        return bytes(spoilt)
