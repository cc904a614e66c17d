"""A serial line in memory that spoils what goes over it, with an emulated controller at its end."""

from __future__ import annotations

from collections import Counter
from types import TracebackType
from typing import Self

import numpy as np

from motor_bridge.core.controller_link import BadReplyError, WheelCounts, parse_counts
from motor_bridge.emulator.emulated_controller import EmulatedController

REPLY_FAULTS = (
    *('silence', 'garbage', 'cut', 'no end', 'twice'),
    *('flipped bit', 'wrong digit', 'wrong number', 'noise'),
)
REQUEST_FAULTS = ('lost CR', 'lost byte', 'noise before')


class CorruptedLine:
    """Bytes to the controller and back, some of them corrupted.

    Attributes:
        faults: how often each struck.
        replies: how many the controller sent.
        wrong: well-formed counts that differ from those that the controller sent, by what the host got.
    """

    def __init__(
        self,
        controller: EmulatedController,
        rng: np.random.Generator,
        fraction: float,
        request_fraction: float,
    ) -> None:
        """Connect a controller; fractions of the replies and of the commands are corrupted."""
        self._controller, self._rng = controller, rng
        self._share, self._request_share = fraction, request_fraction
        self._received = b''
        self.faults: Counter[str] = Counter()
        self.replies = 0
        self.wrong: dict[WheelCounts, WheelCounts] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return

    def write(self, data: bytes) -> None:
        """Send a command, sometimes corrupted."""
        if self._rng.random() < self._request_share:
            data = self._corrupt_request(data)
        for reply in self._controller.receive(data).splitlines(keepends=True):
            self.replies += 1
            self._received += self._corrupt_reply(reply) if self._rng.random() < self._share else reply

    def read_line(self, size_max: int) -> bytes:
        """Return a line, or what there is."""
        size = min(self._received.find(b'\n') + 1 or size_max, size_max)
        line, self._received = self._received[:size], self._received[size:]
        return line

    def drain(self) -> int:
        """Drop everything."""
        return self.discard_received()

    def discard_received(self) -> int:
        """Drop everything."""
        count, self._received = len(self._received), b''
        return count

    def _corrupt_request(self, data: bytes) -> bytes:
        kind = REQUEST_FAULTS[self._rng.integers(len(REQUEST_FAULTS))]
        self.faults[kind] += 1
        if kind == 'lost CR':
            return data.replace(b'\r', b'', 1)
        if kind == 'lost byte':
            place = int(self._rng.integers(len(data)))
            return data[:place] + data[place + 1 :]
        return self._rng.bytes(3).replace(b'\r', b'x') + data

    def _corrupt_reply(self, reply: bytes) -> bytes:
        kind = REPLY_FAULTS[self._rng.integers(len(REPLY_FAULTS))]
        self.faults[kind] += 1
        corrupted = self._corrupt(kind, reply)
        try:
            sent, got = parse_counts(reply), parse_counts(corrupted)
        except BadReplyError:
            return corrupted
        if sent != got:
            self.faults['well-formed wrong counts'] += 1
            self.wrong[got] = sent
        return corrupted

    def _corrupt(self, kind: str, reply: bytes) -> bytes:  # noqa: PLR0911 one return a kind
        place = int(self._rng.integers(len(reply)))
        match kind:
            case 'silence':
                return b''
            case 'garbage':
                return self._rng.bytes(int(self._rng.integers(1, 90)))
            case 'cut':
                return reply[:place] + reply[-2:]
            case 'no end':
                return reply[:-2]
            case 'twice':
                return reply + reply
            case 'flipped bit':
                return (
                    reply[:place] + bytes([reply[place] ^ (1 << self._rng.integers(8))]) + reply[place + 1 :]
                )
            case 'noise':
                return self._rng.bytes(4) + reply
        digits = [k for k, byte in enumerate(reply) if chr(byte).isdigit()]
        if not digits:
            return reply
        if kind == 'wrong number':
            left, right = self._rng.integers(-(2**31), 2**31, 2)
            return f'{left} {right}\r\n'.encode()
        place = int(self._rng.choice(digits))
        return reply[:place] + b'%d' % self._rng.integers(10) + reply[place + 1 :]
