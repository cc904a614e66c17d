"""An emulated controller in a separate process that logs the commands it receives: `_logged_controller.py LINK LOG`."""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from threading import Event, Lock
from time import monotonic

import numpy as np

from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.emulator_settings import EmulatorSettings
from motor_bridge.emulator.pseudo_terminal import PseudoTerminal, RealTimeStepper


class LoggedController(EmulatedController):
    """Writes each command with its time, when its motors get or lose voltage, and when its wheels stand."""

    log = Path()

    def receive(self, data: bytes) -> bytes:
        """Take bytes, and write them down."""
        self._write(data.decode('ascii', 'replace').replace('\r', ';'))
        return super().receive(data)

    def advance(self, until: float) -> None:
        """Let time pass."""
        before = self._state()
        super().advance(until)
        if self._state() != before:
            self._write(self._state())

    def _state(self) -> str:
        if self.is_stopped:
            return 'stopped'
        return 'coasts' if self._firmware.pwm == (0, 0) else 'moves'

    def _write(self, text: str) -> None:
        with self.log.open('a') as file:
            file.write(f'{monotonic():.4f} {text}\n')


def main() -> None:
    """Serve until SIGTERM."""
    link, LoggedController.log = map(Path, sys.argv[1:])
    over, lock = Event(), Lock()
    signal.signal(signal.SIGTERM, lambda *_: over.set())
    controller = LoggedController(EmulatorSettings(), np.random.default_rng(0))
    with PseudoTerminal(controller, lock, link=link), RealTimeStepper(controller, lock):
        print('ready', flush=True)
        while not over.wait(0.2):
            pass


if __name__ == '__main__':
    main()
