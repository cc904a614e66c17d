"""Keeps the conversation with the motor controller going, from a thread of its own."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from threading import Event, Lock, Thread
from time import monotonic
from typing import Protocol

from motor_bridge.core.base_drive import BaseDrive
from motor_bridge.core.controller_link import ControllerLink, ControllerSetup, Line
from motor_bridge.core.count_watch import CountVerdict, turns_between
from motor_bridge.core.encoder_odometry import EncoderOdometry, OdometryState
from motor_bridge.core.serial_protocol import BadReplyError, LinkError, NoReplyError, WheelCounts
from motor_bridge.core.velocity import Velocity
from motor_bridge.loop_report import LoopReport
from motor_bridge.serial_port import PortError

BACK_OFF = (0.1, 2.0)
"""First and longest time before a port is opened again [s]; it doubles each time."""
PATIENCE = 5.0
"""Opening the line resets an Arduino, whose bootloader then listens for up to two seconds [s]."""
BAD_REPLIES_MAX = 10
"""So many in a row are those of a controller that does not answer."""
_BETWEEN_READS = 0.01  # two first counts differ by no more than what wheels turn in this time [s]
_JOIN_MAX = 3.0  # [s]


class OpenLine(Line, AbstractContextManager[Line], Protocol):
    """A line that is closed at the end of a `with` statement."""


class MotorLoop:
    """Drives the controller and reads its encoders.

    Who calls it never waits for the line. Each `cycle` sends the wheels' speeds and reads their counts; a velocity that
    comes in between is sent at once.

    Attributes:
        report: the state of the line.
        odometry: to be read under `lock`.
        drive: likewise.
        lock: held while either changes.
    """

    def __init__(
        self,
        open_line: Callable[[], OpenLine],
        setup: ControllerSetup,
        drive: BaseDrive,
        odometry: EncoderOdometry,
        now: Callable[[], float],
        report: LoopReport,
        show: Callable[[OdometryState], None],
    ) -> None:
        """Prepare; `start` begins.

        Args:
            open_line: opens the serial port, or raises PortError.
            setup: of the controller.
            drive: what the wheels are told.
            odometry: what they say.
            now: the time [s] by which velocities grow old, the limits are kept and odometry is made.
            report: is told what happens.
            show: is called with odometry after each good read, from the loop's thread.
        """
        self._open_line, self._setup, self._now, self._show = open_line, setup, now, show
        self.drive, self.odometry, self.report = drive, odometry, report
        self.lock = Lock()
        self._wake, self._over = Event(), Event()
        self._is_cycle = False
        self._sent: tuple[int, int] | None = None
        self._latest = float('-inf')
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
        with self.lock:
            self.drive.want(velocity, self._now())
        self._wake.set()

    def emergency(self, *, is_on: bool) -> None:
        """Stop at once, or allow velocities that come later."""
        with self.lock:
            self.drive.emergency(is_on=is_on)
        self._wake.set()

    def cycle(self) -> None:
        """Let the speeds be sent and the encoders be read now."""
        self._is_cycle = True
        self._wake.set()

    def _run(self) -> None:
        pause = BACK_OFF[0]
        while not self._over.is_set():
            connections = self.report.connections
            try:
                with self._open_line() as line:
                    self._serve(ControllerLink(line, self._setup))
            except (PortError, LinkError) as fault:
                self.report.lost(str(fault))
            except Exception as fault:  # noqa: BLE001 a fault of ours must not leave the robot without its driver
                self.report.faults[f'{type(fault).__name__} in the loop'] += 1
                self.report.lost(' '.join(f'{type(fault).__name__}: {fault}'.split()))
            with self.lock:
                self.drive.halt()
            pause = BACK_OFF[0] if self.report.connections > connections else min(2.0 * pause, BACK_OFF[1])
            self._over.wait(pause)

    def _serve(self, link: ControllerLink) -> None:
        """Work with an open line until it is gone or all is over."""
        self._meet(link)
        bad_in_row = 0
        while not self._over.is_set():
            self._wake.wait()
            self._wake.clear()
            try:
                self._work(link)
                bad_in_row = 0
            except BadReplyError as fault:
                self.report.faults['bad replies'] += 1
                bad_in_row += 1
                link.find_step()
                self.cycle()  # what half a command made of the speeds must not stand
                if bad_in_row >= BAD_REPLIES_MAX:
                    self._meet_again(link, fault)
            except NoReplyError as fault:
                self.report.faults['no reply'] += 1
                self._meet_again(link, fault)
        link.stop()

    def _meet_again(self, link: ControllerLink, fault: LinkError) -> None:
        """The controller may hang with a command before it: nothing but a stop is sent until it answers."""
        with self.lock:
            self.drive.halt()
        self.report.lost(str(fault))
        self._meet(link)

    def _meet(self, link: ControllerLink) -> None:
        """Greet the controller until it answers as it must.

        Raises:
            PortError: it does not for too long; opening the port again may help.
        """
        end = monotonic() + PATIENCE
        while not self._over.is_set():
            try:
                counts = self._first_counts(link)
            except LinkError as fault:
                if monotonic() > end:
                    raise PortError(str(fault)) from fault
                self.report.lost(str(fault))
                continue
            with self.lock:
                self.drive.halt()
                self.odometry.reach.command(0, 0)
                verdict = self.odometry.resume(counts, self._now())
            self._sent = (0, 0)
            began = ', its encoders began anew' if verdict is CountVerdict.RESTARTED else ''
            self.report.connected(f'the controller answers{began}')
            return

    def _first_counts(self, link: ControllerLink) -> WheelCounts:
        """Return counts that two reads confirm: nothing that came before can."""
        first = link.greet()
        second = link.read_counts()
        if max(map(abs, turns_between(first, second))) > self.odometry.reach.pushed(_BETWEEN_READS):
            raise BadReplyError('two counts of one moment differ; check wiring and noise')
        return second

    def _work(self, link: ControllerLink) -> None:
        is_cycle, self._is_cycle = self._is_cycle, False
        now = self._now()
        with self.lock:
            if now < self._latest:
                self.report.faults['time went back'] += 1
                self.drive.halt()
                self.odometry.time_jumped()
            self._latest = now
            ticks = self.drive.next_ticks(now)
            self.odometry.reach.command(*ticks)
        if is_cycle or ticks != self._sent:
            self._sent = None
            link.set_speeds(*ticks)
            self._sent = ticks
        if is_cycle and self._read(link) is CountVerdict.ASK_AGAIN:
            self._read(link)

    def _read(self, link: ControllerLink) -> CountVerdict:
        counts = link.read_counts()
        with self.lock:
            verdict = self.odometry.take(counts, self._now())
            state = self.odometry.state
        if verdict is CountVerdict.TAKEN:
            self._show(state)
        return verdict
