"""Advances an emulated controller in real time."""

from __future__ import annotations

from threading import Event, Lock, Thread
from time import monotonic
from types import TracebackType
from typing import Self

from motor_bridge.emulator.emulated_controller import EmulatedController

_PERIOD = 0.002  # [s]
_STEP_MAX = 0.05  # longest step, so that time stops while the process is suspended [s]


class RealTimeStepper:
    """Advances a controller from a thread; a context manager."""

    def __init__(self, controller: EmulatedController, lock: Lock) -> None:
        """Start at the controller's present time.

        Args:
            controller: controller to advance.
            lock: protects the controller.
        """
        self._controller, self._lock = controller, lock
        self._stop_event = Event()
        self._thread = Thread(target=self._run, daemon=True)

    def __enter__(self) -> Self:
        """Start the thread."""
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop the thread."""
        self._stop_event.set()
        self._thread.join()

    def _run(self) -> None:
        before = monotonic()
        while not self._stop_event.wait(_PERIOD):
            now = monotonic()
            with self._lock:
                self._controller.advance(self._controller.time + min(now - before, _STEP_MAX))
            before = now
