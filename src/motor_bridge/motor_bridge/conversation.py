"""What is said to the motor controller, and what is done when it does not answer as it must."""

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
"""Opening the line resets an Arduino, whose bootloader then listens for up to two seconds [s]."""
BAD_REPLIES_MAX = 10
"""So many in a row are those of a controller that does not answer."""
_BETWEEN_READS = 0.01  # two first counts differ by no more than what wheels turn in this time [s]


class Conversation:
    """Drives the wheels and reads their encoders over an open line.

    Attributes:
        report: the state of the line.
        odometry: to be touched under `lock`.
        drive: likewise.
        lock: held while either changes.
    """

    def __init__(
        self,
        drive: BaseDrive,
        odometry: EncoderOdometry,
        now: Callable[[], float],
        report: LoopReport,
        show: Callable[[OdometryState], None],
    ) -> None:
        """Know no controller yet.

        Args:
            drive: what the wheels are told.
            odometry: what they say.
            now: the time [s] by which velocities grow old, the limits are kept and odometry is made.
            report: is told what happens.
            show: is called with odometry after each good read.
        """
        self._now, self._show = now, show
        self.drive, self.odometry, self.report = drive, odometry, report
        self.lock = Lock()
        self._sent: tuple[int, int] | None = None
        self._latest = float('-inf')
        self._bad_in_row = 0

    def meet(self, link: ControllerLink, is_over: Event) -> None:
        """Greet the controller until it answers as it must, or until all is over.

        Raises:
            PortError: it does not for too long; opening the port again may help.
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
            began = ', its encoders began anew' if verdict is CountVerdict.RESTARTED else ''
            self.report.connected(f'the controller answers{began}')
            return

    def step(self, link: ControllerLink, is_over: Event, *, is_cycle: bool) -> bool:
        """Send what the wheels are to do and, once a cycle, read what they did.

        Args:
            link: to a controller that was met.
            is_over: ends the waiting for a controller that fell silent.
            is_cycle: whether encoders are to be read; else speeds are sent only if they changed.

        Returns:
            whether it went well; if not, a whole cycle should follow at once.

        Raises:
            PortError: the port is gone, or the controller fell silent for too long.
        """
        try:
            self._send(link, always=is_cycle)
            if is_cycle and self._read(link) is CountVerdict.ASK_AGAIN:
                self._read(link)
        except BadReplyError as fault:
            self.report.faults['bad replies'] += 1
            self._bad_in_row += 1
            link.find_step()  # this may let half a command act, so that speeds must be sent anew
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
        """The controller may hang with a command before it: nothing but a stop is sent until it answers."""
        with self.lock:
            self.drive.halt()
        self.report.lost(str(fault))
        self.meet(link, is_over)

    def _first_counts(self, link: ControllerLink) -> WheelCounts:
        """Return counts that two reads confirm: nothing that came before can."""
        first = link.greet()
        second = link.read_counts()
        if max(map(abs, turns_between(first, second))) > self.odometry.reach.pushed(_BETWEEN_READS):
            raise BadReplyError('two counts of one moment differ; check wiring and noise')
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
