"""Keeps the conversation with the motor controller going, from a thread of its own."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from threading import Event, Thread
from typing import Protocol

from motor_bridge.conversation import Conversation
from motor_bridge.core.controller_link import ControllerLink, ControllerSetup, Line
from motor_bridge.core.serial_protocol import LinkError
from motor_bridge.core.velocity import Velocity
from motor_bridge.serial_port import PortError

BACK_OFF = (0.1, 2.0)
"""First and longest time before a port is opened again [s]; it doubles each time."""
_JOIN_MAX = 3.0  # [s]


class OpenLine(Line, AbstractContextManager[Line], Protocol):
    """A line that is closed at the end of a `with` statement."""


class MotorLoop:
    """Opens the line, meets the controller, and begins again when either is gone.

    Who calls it never waits for the line. Each `cycle` sends the wheels' speeds and reads their counts; a velocity that
    comes in between is sent at once.
    """

    def __init__(
        self,
        open_line: Callable[[], OpenLine],
        setup: ControllerSetup,
        conversation: Conversation,
        now: Callable[[], float],
    ) -> None:
        """Prepare; `start` begins.

        Args:
            open_line: opens the serial port, or raises PortError.
            setup: of the controller.
            conversation: what is said.
            now: the time by which velocities grow old [s].
        """
        self._open_line, self._setup, self._now = open_line, setup, now
        self._talk = conversation
        self._wake, self._over, self._cycle_due = Event(), Event(), Event()
        self._thread = Thread(target=self._run, name='motor loop', daemon=True)

    def start(self) -> None:
        """Look for the controller."""
        self._thread.start()

    def close(self) -> None:
        """Stop the motors and let the port go."""
        self._over.set()
        self._wake.set()
        if self._thread.is_alive():
            self._thread.join(_JOIN_MAX)

    def want(self, velocity: Velocity) -> None:
        """Drive so, as soon as the limits allow."""
        with self._talk.lock:
            self._talk.drive.want(velocity, self._now())
        self._wake.set()

    def emergency(self, *, is_on: bool) -> None:
        """Stop at once, or allow velocities that come later."""
        with self._talk.lock:
            self._talk.drive.emergency(is_on=is_on)
        self._wake.set()

    def cycle(self) -> None:
        """Let the speeds be sent and the encoders be read now."""
        self._cycle_due.set()
        self._wake.set()

    def _run(self) -> None:
        pause, report = BACK_OFF[0], self._talk.report
        while not self._over.is_set():
            connections = report.connections
            try:
                with self._open_line() as line:
                    self._serve(ControllerLink(line, self._setup))
            except (PortError, LinkError) as fault:
                report.lost(str(fault))
            except Exception as fault:  # noqa: BLE001 a fault of ours must not leave the robot without its driver
                report.faults[f'{type(fault).__name__} in the loop'] += 1
                report.lost(' '.join(f'{type(fault).__name__}: {fault}'.split()))
            with self._talk.lock:
                self._talk.drive.halt()
            pause = BACK_OFF[0] if report.connections > connections else min(2.0 * pause, BACK_OFF[1])
            self._over.wait(pause)

    def _serve(self, link: ControllerLink) -> None:
        """Work with an open line until it is gone or all is over; whatever ends it, the motors are stopped."""
        try:
            self._talk.meet(link, self._over)
            while not self._over.is_set():
                self._wake.wait()
                self._wake.clear()
                is_cycle = self._cycle_due.is_set()
                self._cycle_due.clear()
                if not self._talk.step(link, self._over, is_cycle=is_cycle):
                    self.cycle()
        finally:
            with suppress(PortError, LinkError):
                link.leave()
