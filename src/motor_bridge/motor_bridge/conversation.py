"""Session with the motor controller: handshake, command cycle and recovery from link errors."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event, Lock
from time import monotonic

from motor_bridge.core.base_drive import BaseDrive
from motor_bridge.core.controller_link import ControllerLink
from motor_bridge.core.count_watch import CountVerdict, turns_between
from motor_bridge.core.encoder_odometry import EncoderOdometry, OdometryState
from motor_bridge.core.serial_protocol import BadReplyError, LinkError, NoReplyError, WheelCounts
from motor_bridge.loop_report import LoopReport
from motor_bridge.serial_port import PortError

PATIENCE = 5.0
"""Timeout of the handshake [s]; opening the port resets an Arduino, whose bootloader takes up to 2 s."""
BAD_REPLIES_MAX = 10
"""Invalid replies in a row after which the session reconnects."""
_BETWEEN_READS = 0.01  # upper bound of the time between the first two reads [s]


class Conversation:
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
        report: LoopReport,
        show: Callable[[OdometryState], None],
    ) -> None:
        """Start without a controller.

        Args:
            drive: wheel speed commands.
            odometry: wheel odometry.
            now: returns the time of timeouts, limits and odometry [s].
            report: receives changes of the link's state.
            publish: called with odometry after each valid read.
        """
        self._now, self._show = now, show
        self.drive, self.odometry, self.report = drive, odometry, report
        self.lock = Lock()
        self._sent: tuple[int, int] | None = None
        self._latest = float('-inf')
        self._bad_in_row = 0

    def meet(self, link: ControllerLink, is_over: Event) -> None:
        """Repeat the handshake until it succeeds or the stop event is set.

        Raises:
            PortError: timeout; reopening the port may help.
        """
        end = monotonic() + PATIENCE
        while not is_over.is_set():
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
            self._sent, self._bad_in_row = (0, 0), 0
            began = ', its encoders were reset' if verdict is CountVerdict.RESTARTED else ''
            self.report.connected(f'connected to the controller{began}')
            return

    def step(self, link: ControllerLink, is_over: Event, *, is_cycle: bool) -> bool:
        """Send the wheel speeds and, once per cycle, read the encoders.

        Args:
            link: link to a connected controller.
            stop_event: ends the waiting for a controller that does not reply.
            is_cycle: whether to read the encoders; otherwise speeds are sent only if they changed.

        Returns:
            True on success; otherwise a whole cycle should follow at once.

        Raises:
            PortError: the port is disconnected, or the controller does not reply for too long.
        """
        try:
            self._send(link, always=is_cycle)
            if is_cycle and self._read(link) is CountVerdict.ASK_AGAIN:
                self._read(link)
        except BadReplyError as fault:
            self.report.faults['bad replies'] += 1
            self._bad_in_row += 1
            link.find_step()  # this may execute a partial command, so speeds must be sent again
            if self._bad_in_row >= BAD_REPLIES_MAX:
                self._meet_again(link, is_over, fault)
            return False
        except NoReplyError as fault:
            self.report.faults['no reply'] += 1
            self._meet_again(link, is_over, fault)
            return False
        self._bad_in_row = 0
        return True

    def _meet_again(self, link: ControllerLink, is_over: Event, fault: LinkError) -> None:
        """Reconnect; a hung controller may have a pending command, so only stops are sent until it replies."""
        with self.lock:
            self.drive.halt()
        self.report.lost(str(fault))
        self.meet(link, is_over)

    def _first_counts(self, link: ControllerLink) -> WheelCounts:
        """Return counts that two reads confirm, since there are no earlier ones."""
        first = link.greet()
        second = link.read_counts()
        if max(map(abs, turns_between(first, second))) > self.odometry.reach.pushed(_BETWEEN_READS):
            raise BadReplyError('two consecutive reads of the counts differ; check wiring and noise')
        return second

    def _send(self, link: ControllerLink, *, always: bool) -> None:
        now = self._now()
        with self.lock:
            if now < self._latest:
                self.report.time_went_back()
                self.drive.halt()
                self.odometry.time_jumped()
            self._latest = now
            ticks = self.drive.next_ticks(now)
            self.odometry.reach.command(*ticks)
        if always or ticks != self._sent:
            self._sent = None
            link.set_speeds(*ticks)
            self._sent = ticks

    def _read(self, link: ControllerLink) -> CountVerdict:
        counts = link.read_counts()
        with self.lock:
            verdict = self.odometry.take(counts, self._now())
            state = self.odometry.state
        if verdict is CountVerdict.TAKEN:
            self._show(state)
        return verdict
