"""Serves an emulated controller on a pseudo-terminal, and advances it in real time."""

import os
import pty
import select
import tty
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Lock, Thread
from time import monotonic, sleep
from typing import Self

import numpy as np

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.emulator.emulated_controller import EmulatedController

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


_POLL_PERIOD = 0.02  # polling period [s]
_CHUNK = 4096
_STEP_PERIOD = 0.002  # [s]
_STEP_MAX = 0.05  # longest step, so that time stops while the process is suspended [s]


class PseudoTerminal:
    """A virtual serial port with a controller, a context manager.

    Attributes:
        path: path of the port; it changes with each reconnection.
    """

    path: str

    def __init__(
        self, controller: EmulatedController, lock: Lock, *, faults: LineFaults | None = None, link: Path | None = None
    ) -> None:
        """Prepare; the port exists inside of the `with` statement.

        The lock protects the controller: hold it to advance its time. ``link`` is a symbolic link to the port, renewed
        at each reconnection.
        """
        self._controller, self._lock, self._link = controller, lock, link
        self._faults = faults or LineFaults(np.random.default_rng())
        self._replies = deque[tuple[float, bytes]]()  # on their way, with the times when they arrive [s]
        self._stop_event = Event()
        self._thread = Thread(target=self._serve, daemon=True)

    def __enter__(self) -> Self:
        self._plug()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop_event.set()
        self._thread.join()
        self._unplug()

    def _plug(self) -> None:
        # Keep the port's end open here, too: a terminal that no process has open accepts no bytes.
        self._master, self._port = pty.openpty()
        self._replies.clear()
        tty.setraw(self._port)
        self.path = os.ttyname(self._port)
        if self._link is not None:
            if self._link.exists() and not self._link.is_symlink():
                raise MotorBridgeError(f'{self._link} exists and is not a symbolic link; choose another path')
            temporary = self._link.with_name(f'.{self._link.name}.new')
            temporary.unlink(missing_ok=True)
            temporary.symlink_to(self.path)
            temporary.replace(self._link)

    def _unplug(self) -> None:
        if self._link is not None:
            self._link.unlink(missing_ok=True)
        for file in (self._master, self._port):
            os.close(file)

    def _serve(self) -> None:
        before = monotonic()
        while not self._stop_event.is_set():
            now = monotonic()
            self._apply_faults(now - before)
            before = now
            while self._replies and self._replies[0][0] <= now:
                os.write(self._master, self._replies.popleft()[1])
            due = self._replies[0][0] - now if self._replies else _POLL_PERIOD
            readable = select.select([self._master], [], [], min(due, _POLL_PERIOD))[0]
            if readable and self._faults.is_active('hang'):
                sleep(_POLL_PERIOD)
            elif readable:
                self._answer(os.read(self._master, _CHUNK))

    def _answer(self, data: bytes) -> None:
        with self._lock:
            reply = self._controller.receive(self._faults.to_controller(data))
        reply = b''.join(map(self._faults.to_host, reply.splitlines(keepends=True)))
        due = monotonic() + self._faults.delay
        if reply and not self._replies and self._faults.delay == 0.0:
            os.write(self._master, reply)
        elif reply:
            self._replies.append((max(due, self._replies[-1][0] if self._replies else due), reply))

    def _apply_faults(self, elapsed: float) -> None:
        """Apply the faults that do not concern single bytes."""
        faults = self._faults
        if faults.consume('reset'):
            with self._lock:
                self._controller.reset()
        if faults.is_active('unplug'):
            self._unplug()
            while faults.is_active('unplug') and not self._stop_event.wait(_POLL_PERIOD):
                faults.advance_time(_POLL_PERIOD)
            self._plug()
        faults.advance_time(elapsed)


class RealTimeStepper:
    """Advances a controller from a thread; a context manager."""

    def __init__(self, controller: EmulatedController, lock: Lock) -> None:
        """Start at the controller's present time; the lock protects the controller."""
        self._controller, self._lock = controller, lock
        self._stop_event = Event()
        self._thread = Thread(target=self._run, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop_event.set()
        self._thread.join()

    def _run(self) -> None:
        before = monotonic()
        while not self._stop_event.wait(_STEP_PERIOD):
            now = monotonic()
            with self._lock:
                self._controller.advance(self._controller.time + min(now - before, _STEP_MAX))
            before = now
