"""Fault injection on the serial line and the controller."""

from dataclasses import dataclass

import numpy as np

from motor_bridge.core.motor_bridge_error import MotorBridgeError

FAULTS = ('silence', 'hang', 'garbage', 'wrong', 'lost_cr', 'reset', 'unplug', 'latency', 'jitter')
"""silence S, hang S, unplug S: for S seconds; garbage N, wrong N, lost_cr N: the next N; reset.

latency S, jitter S: from now on replies come S seconds later, and by up to so much more, at random, in their order.
"""
_TIMED = ('silence', 'hang', 'unplug')


@dataclass(frozen=True)
class FaultRequest:
    """A fault to inject: one of FAULTS, and its duration [s] or number of replies or commands."""

    kind: str
    amount: float


def parse_fault_request(line: str) -> FaultRequest:
    """Parse a line such as ``silence 1.5``; raise a MotorBridgeError if it is invalid."""
    kind, _, amount = line.strip().partition(' ')
    if kind not in FAULTS:
        raise MotorBridgeError(f'unknown fault {kind!r}; choose one of {", ".join(FAULTS)}')
    try:
        number = float(amount or 1.0)
    except ValueError:
        number = 0.0
    if not 0.0 < number < 1e6:
        raise MotorBridgeError(f'{kind} {amount}: give a number above 0 after the fault')
    return FaultRequest(kind, number)


class LineFaults:
    """Corrupts the data on the line."""

    def __init__(self, rng: np.random.Generator) -> None:
        """Start without faults."""
        self._rng = rng
        self._remaining: dict[str, float] = dict.fromkeys(FAULTS, 0.0)

    def inject(self, request: FaultRequest) -> None:
        """Inject a fault."""
        self._remaining[request.kind] = request.amount

    def advance_time(self, elapsed: float) -> None:
        """Advance the timed faults [s]."""
        for kind in _TIMED:
            self._remaining[kind] = max(0.0, self._remaining[kind] - elapsed)

    @property
    def delay(self) -> float:
        """Delay of a reply [s]."""
        return self._remaining['latency'] + self._remaining['jitter'] * float(self._rng.random())

    def is_active(self, kind: str) -> bool:
        """Return whether a fault is active."""
        return self._remaining[kind] > 0.0

    def consume(self, kind: str) -> bool:
        """Return whether a counted fault applies now, and decrement its counter."""
        if self._remaining[kind] < 1.0:
            return False
        self._remaining[kind] -= 1.0
        return True

    def to_controller(self, data: bytes) -> bytes:
        """Return the data that the controller receives."""
        kept = bytearray()
        for byte in data:
            if byte != 0x0D or not self.consume('lost_cr'):
                kept.append(byte)
        return bytes(kept)

    def to_host(self, reply: bytes) -> bytes:
        """Return the reply that the host receives."""
        if not reply or self.is_active('silence'):
            return b''
        if self.consume('garbage'):
            return self._rng.bytes(int(self._rng.integers(1, 40)))
        if reply[:1].isdigit() or reply[:1] == b'-':
            return self._wrong_counts(reply) if self.consume('wrong') else reply
        return reply

    def _wrong_counts(self, reply: bytes) -> bytes:
        """Return a well-formed reply with one digit changed."""
        digits = [index for index, byte in enumerate(reply) if chr(byte).isdigit()]
        corrupted = bytearray(reply)
        index = int(self._rng.choice(digits))
        corrupted[index] = 0x30 + (corrupted[index] - 0x30 + int(self._rng.integers(1, 10))) % 10
        return bytes(corrupted)
