"""Thread that runs the session with the motor controller."""

from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from threading import Event, Thread
from typing import Protocol

from motor_bridge.core.controller_protocol import ControllerProtocol, LinkError, SerialLine
from motor_bridge.core.diff_drive_kinematics import Velocity
from motor_bridge.link.controller_session import ControllerSession
from motor_bridge.link.serial_port import PortError

BACK_OFF = (0.1, 2.0)
"""First and longest back-off before the port is reopened [s]; it doubles each time."""
_JOIN_TIMEOUT = 3.0  # [s]


class OpenSerialLine(SerialLine, AbstractContextManager[SerialLine], Protocol):
    """A serial line that is also a context manager."""


class MotorLoop:
    """Opens the port, connects to the controller, and reconnects after errors.

    Callers never wait for the line. Each `cycle` sends the wheel speeds and reads the encoders; a new target velocity
    is sent at once.
    """

    def __init__(
        self,
        open_line: Callable[[], OpenSerialLine],
        make_protocol: Callable[[SerialLine], ControllerProtocol],
        session: ControllerSession,
        now: Callable[[], float],
    ) -> None:
        """Prepare; call `start` to begin. ``now`` returns the time of timeouts [s]."""
        self._open_line, self._make_protocol, self._now = open_line, make_protocol, now
        self._session = session
        self._wake, self._stop_event, self._cycle_due = Event(), Event(), Event()
        self._thread = Thread(target=self._run, name='motor loop', daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self) -> None:
        """Stop the motors and close the port."""
        self._stop_event.set()
        self._wake.set()
        if self._thread.is_alive():
            self._thread.join(_JOIN_TIMEOUT)

    def set_target(self, velocity: Velocity) -> None:
        """Set the target velocity."""
        with self._session.lock:
            self._session.drive.set_target(velocity, self._now())
        self._wake.set()

    def wake(self) -> None:
        """Send speeds that have changed at once."""
        self._wake.set()

    def cycle(self) -> None:
        """Request a cycle: send the speeds and read the encoders."""
        self._cycle_due.set()
        self._wake.set()

    def _run(self) -> None:
        pause, report = BACK_OFF[0], self._session.report
        while not self._stop_event.is_set():
            connections = report.connections
            try:
                with self._open_line() as line:
                    self._serve(self._make_protocol(line))
            except (PortError, LinkError) as fault:
                report.set_disconnected(str(fault))
            except Exception as fault:  # noqa: BLE001 the loop must survive programming errors
                report.faults[f'{type(fault).__name__} in the loop'] += 1
                report.set_disconnected(' '.join(f'{type(fault).__name__}: {fault}'.split()))
            with self._session.lock:
                self._session.drive.halt()
            pause = BACK_OFF[0] if report.connections > connections else min(2.0 * pause, BACK_OFF[1])
            self._stop_event.wait(pause)

    def _serve(self, link: ControllerProtocol) -> None:
        """Serve an open line until an error or the stop event; the motors are always stopped at the end."""
        try:
            self._session.connect(link, self._stop_event)
            while not self._stop_event.is_set():
                self._wake.wait()
                self._wake.clear()
                is_cycle = self._cycle_due.is_set()
                self._cycle_due.clear()
                if not self._session.step(link, self._stop_event, is_cycle=is_cycle):
                    self.cycle()
        finally:
            with suppress(PortError, LinkError):
                link.stop_and_resynchronize()
