"""Session with the motor controller: handshake, command cycle, recovery from link errors, and their report."""

from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, field
from math import inf
from threading import Event, Lock, Thread
from time import monotonic
from typing import Protocol

from motor_bridge.core.base_drive import BaseDrive
from motor_bridge.core.controller_protocol import (
    BadReplyError,
    ControllerProtocol,
    LinkError,
    NoReplyError,
    SerialLine,
    WheelCounts,
)
from motor_bridge.core.diff_drive_kinematics import Velocity
from motor_bridge.core.encoder_monitor import CountStatus, count_difference
from motor_bridge.core.encoder_odometry import EncoderOdometry, OdometryState
from motor_bridge.link.serial_port import PortError

CONNECT_TIMEOUT = 5.0
"""Timeout of the handshake [s]; opening the port resets an Arduino, whose bootloader takes up to 2 s."""
BAD_REPLIES_MAX = 10
"""Invalid replies in a row after which the session reconnects."""
LATENCIES = 0.02, 0.4
"""First and greatest latency of the line to allow for [s]."""
_BETWEEN_READS = 0.01  # upper bound of the time between the first two reads [s]


def longer_latency(latency: float) -> float:
    """Return the latency to allow for after a failed handshake [s]."""
    return min(4.0 * latency, LATENCIES[1])


@dataclass
class LinkReport:
    """State of the serial link and its fault counters.

    Attributes:
        log: called with each new state: one line, and whether the controller is connected.
        state: latest state, one line.
        is_connected: whether the controller is connected.
        faults: number of faults by kind.
        connections: number of successful handshakes.
    """

    log: Callable[[str, bool], None]
    state: str = 'no controller yet'
    is_connected: bool = False
    faults: Counter[str] = field(default_factory=Counter)
    connections: int = 0

    def set_connected(self, message: str) -> None:
        """Report a successful handshake."""
        self.connections += 1
        self._set_state(message, is_connected=True)

    def set_disconnected(self, message: str) -> None:
        """Report a lost or missing connection."""
        self._set_state(message, is_connected=False)

    def count_time_jump(self) -> None:
        """Report that the clock jumped back."""
        self.faults['clock jumped back'] += 1
        self.log('clock jumped back: the robot stops, odometry continues from the current pose', False)

    def _set_state(self, message: str, *, is_connected: bool) -> None:
        if (message, is_connected) != (self.state, self.is_connected):
            self.state, self.is_connected = message, is_connected
            self.log(message, is_connected)


class ControllerSession:
    """Sends wheel speeds and reads encoders over an open serial line.

    Attributes:
        report: state of the link.
        odometry: wheel odometry; access it under `lock`.
        drive: wheel speed commands; access it under `lock`.
        lock: protects odometry and drive.
    """

    def __init__(
        self,
        drive: BaseDrive,
        odometry: EncoderOdometry,
        now: Callable[[], float],
        report: LinkReport,
        publish: Callable[[OdometryState], None],
    ) -> None:
        """Start without a controller.

        ``now`` returns the time of timeouts, limits and odometry [s]; ``publish`` is called after each valid read.
        """
        self._now, self._publish = now, publish
        self.drive, self.odometry, self.report = drive, odometry, report
        self.lock = Lock()
        self._sent: tuple[int, int] | None = None
        self._last_time = -inf
        self._bad_replies_in_row = 0

    def connect(self, link: ControllerProtocol, stop_event: Event) -> None:
        """Repeat the handshake until it succeeds or the stop event is set.

        Raises:
            PortError: timeout; reopening the port may help.
        """
        deadline, latency = monotonic() + CONNECT_TIMEOUT, LATENCIES[0]
        while not stop_event.is_set():
            try:
                counts = self._first_counts(link, latency)
            except LinkError as fault:
                if monotonic() > deadline:
                    raise PortError(str(fault)) from fault
                self.report.set_disconnected(str(fault))
                latency = longer_latency(latency)
                continue
            with self.lock:
                self.drive.halt()
                self.odometry.motion_bounds.set_commanded(0, 0)
                status = self.odometry.resume(counts, self._now())
            self._sent, self._bad_replies_in_row = (0, 0), 0
            detail = ', its encoders were reset' if status is CountStatus.RESTARTED else ''
            self.report.set_connected(f'connected to the controller ({link.name}){detail}')
            return

    def step(self, link: ControllerProtocol, stop_event: Event, *, is_cycle: bool) -> bool:
        """Send the wheel speeds and, once per cycle, read the encoders; between cycles only changed speeds are sent.

        Returns:
            True on success; otherwise a whole cycle should follow at once.

        Raises:
            PortError: the port is disconnected, or the controller does not reply for too long.
        """
        try:
            self._send(link, always=is_cycle)
            if is_cycle and self._read(link) is CountStatus.RETRY:
                self._read(link)
        except BadReplyError as fault:
            self.report.faults['bad replies'] += 1
            self._bad_replies_in_row += 1
            link.resynchronize()  # this may execute a partial command, so speeds must be sent again
            if self._bad_replies_in_row >= BAD_REPLIES_MAX:
                self._reconnect(link, stop_event, fault)
            return False
        except NoReplyError as fault:
            self.report.faults['no reply'] += 1
            self._reconnect(link, stop_event, fault)
            return False
        self._bad_replies_in_row = 0
        return True

    def _reconnect(self, link: ControllerProtocol, stop_event: Event, fault: LinkError) -> None:
        """Reconnect; a hung controller may have a pending command, so only stops are sent until it replies."""
        with self.lock:
            self.drive.halt()
        self.report.set_disconnected(str(fault))
        self.connect(link, stop_event)

    def _first_counts(self, link: ControllerProtocol, latency: float) -> WheelCounts:
        """Return counts that two reads confirm, since there are no earlier ones."""
        first = link.connect(latency)
        second = link.read_counts()
        turn_max = self.odometry.motion_bounds.pushed_turn_max(_BETWEEN_READS)
        if max(map(abs, count_difference(first, second))) > turn_max:
            raise BadReplyError('two consecutive reads of the counts differ; check wiring and noise')
        return second

    def _send(self, link: ControllerProtocol, *, always: bool) -> None:
        now = self._now()
        with self.lock:
            if now < self._last_time:
                self.report.count_time_jump()
                self.drive.halt()
                self.odometry.handle_time_jump()
            elif now - self._last_time > link.auto_stop:
                self.drive.halt()  # the controller has stopped, so the limits begin at rest
            self._last_time = now
            ticks = self.drive.next_ticks(now)
            self.odometry.motion_bounds.set_commanded(*ticks)
        if always or ticks != self._sent:
            self._sent = None
            link.write_speeds(*ticks)
            self._sent = ticks

    def _read(self, link: ControllerProtocol) -> CountStatus:
        counts = link.read_counts()
        with self.lock:
            status = self.odometry.update(counts, self._now())
            state = self.odometry.state
        if status is CountStatus.ACCEPTED:
            self._publish(state)
        return status


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
