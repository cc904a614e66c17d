"""A drive over a line that spoils replies and commands, in memory and simulated time."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from threading import Event

import numpy as np
from _corrupted_line import CorruptedLine

from motor_bridge.core.base_drive import BaseDrive
from motor_bridge.core.controller_link import ControllerLink, ControllerSetup
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, Velocity
from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.encoder_odometry import EncoderOdometry, OdometryState
from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.emulator_settings import EmulatorSettings
from motor_bridge.link.controller_session import ControllerSession, LinkReport

PERIOD = 1.0 / 30.0
ROUNDS = 3
"""Of speeds and counts in each period, so that a million replies take minutes and not an hour."""
SETUP = ControllerSetup(57600, (20, 12, 0, 50))


@dataclass
class FuzzTally:
    """What came of it.

    Attributes:
        replies: that the controller sent.
        exceptions: that came out.
        over_limit: number of commanded wheel speeds beyond the limits.
        wrong_sent: well-formed wrong counts that the line made.
        wrong_accepted: number of these that odometry accepted.
        wrong_mm: errors of the accepted ones: distance of a wheel [mm].
        fastest: greatest commanded wheel speed, as a fraction of the limit.
        jump: greatest excess of an odometry step over the true step [m].
        path: that the wheels made [m].
        faults: number of injected line faults by kind.
        status_counts: number of encoder counts by status.
    """

    replies: int = 0
    exceptions: int = 0
    over_limit: int = 0
    wrong_sent: int = 0
    wrong_accepted: int = 0
    wrong_mm: list[float] = field(default_factory=list)
    fastest: float = 0.0
    jump: float = 0.0
    path: float = 0.0
    faults: Counter[str] = field(default_factory=Counter)
    status_counts: Counter[str] = field(default_factory=Counter)


class FuzzedDrive:
    """A robot that is driven at random over a corrupted line."""

    def __init__(self, seed: int, fraction: float = 0.05, request_fraction: float = 0.003) -> None:
        """Prepare.

        Args:
            seed: random seed.
            fraction: fraction of the replies that are corrupted.
            request_fraction: fraction of the commands that are corrupted.
        """
        self.rng = np.random.default_rng(seed)
        settings = DriveSettings()
        self.base = DiffDriveKinematics(settings)
        self.limit = max(
            self.base.to_wheel_ticks(Velocity(settings.max_linear_velocity, settings.max_angular_velocity))
        )
        robot = EmulatorSettings(encoder_noise=0.0, slip_sigma=0.0)
        self.controller = EmulatedController(robot, self.rng.spawn(1)[0])
        self.line = CorruptedLine(self.controller, self.rng.spawn(1)[0], fraction, request_fraction)
        self.states: list[OdometryState] = []
        drive = BaseDrive(self.base, settings, PERIOD)
        self.odometry = EncoderOdometry(self.base, settings)
        report = LinkReport(lambda *_: None)
        self.session = ControllerSession(drive, self.odometry, self._now, report, self.states.append)
        self.link = ControllerLink(self.line, SETUP)
        self.over = Event()
        self.tally = FuzzTally()
        self._wanted = Velocity()
        self._before = self._wheel_distances()

    def _now(self) -> float:
        return self.controller.time

    def _wheel_distances(self) -> tuple[float, float]:
        left, right = self.controller._body.wheel_angles  # noqa: SLF001 the truth
        return 0.033 * left, 0.033 * right

    def run(self, replies: int) -> FuzzTally:
        """Drive until the controller has sent so many replies."""
        self.session.connect(self.link, self.over)
        while self.line.replies < replies:
            self._step()
        tally = self.tally
        tally.replies, tally.faults = self.line.replies, self.line.faults
        tally.wrong_sent = self.line.faults['well-formed wrong counts']
        tally.status_counts = Counter({status.value: n for status, n in self.odometry.status_counts.items()})
        return tally

    def _step(self) -> None:
        self.controller.advance(self.controller.time + PERIOD)
        if self.rng.random() < 0.02:
            self._wanted = Velocity(float(self.rng.normal(0.0, 0.4)), float(self.rng.normal(0.0, 1.0)))
        self.session.drive.set_target(self._wanted, self._now())
        for _ in range(ROUNDS):
            shown = len(self.states)
            try:
                while not self.session.step(self.link, self.over, is_cycle=True):
                    pass
            except Exception:  # noqa: BLE001 it is counted
                self.tally.exceptions += 1
            self._count_speeds()
            if len(self.states) > shown:
                self._count_odometry()

    def _count_speeds(self) -> None:
        commanded = self.session.drive.velocity
        ticks = max(map(abs, self.base.to_wheel_ticks(commanded)))
        self.tally.fastest = max(self.tally.fastest, ticks / self.limit)
        self.tally.over_limit += ticks > self.limit + 1e-9

    def _count_odometry(self) -> None:
        """Compare the counts that odometry took with the wheels' true ones."""
        good = self.odometry._monitor.last_accepted  # noqa: SLF001 what was taken
        if good is None:
            return
        sent = self.line.wrong.get(good[0])
        if sent is not None and good[1] == self._now():
            self.tally.wrong_accepted += 1
            wrong = max(abs(good[0].left - sent.left), abs(good[0].right - sent.right))
            self.tally.wrong_mm.append(1e3 * self.base.metres_per_tick * wrong)
        self.line.wrong.clear()
        distances = self._wheel_distances()
        true = 0.5 * (distances[0] - self._before[0] + distances[1] - self._before[1])
        self._before = distances
        self.tally.path += abs(true)
        if len(self.states) >= 2:
            a, b = self.states[-2].T_odom_base, self.states[-1].T_odom_base
            self.tally.jump = max(self.tally.jump, a.distance_to(b) - abs(true))
        del self.states[:-1]


def fuzz(replies: int, seed: int) -> FuzzTally:
    """Drive over a corrupted line until so many replies were sent."""
    return FuzzedDrive(seed).run(replies)
