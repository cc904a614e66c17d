"""A drive over a line that corrupts replies and commands, in memory and simulated time."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from threading import Event

import numpy as np

from motor_bridge.core.base_drive import BaseDrive
from motor_bridge.core.controller_protocol import BadReplyError, ControllerSetup, WheelCounts, without_checksum
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, DriveSettings, Velocity
from motor_bridge.core.encoder_odometry import EncoderOdometry, OdometryState
from motor_bridge.core.ros_arduino_bridge import RosArduinoBridge, parse_counts
from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.firmware import EmulatorSettings
from motor_bridge.link.controller_session import ControllerSession, LinkReport

PERIOD = 1.0 / 30.0
ROUNDS = 3  # number of speeds and counts in each period, so that a million replies take minutes and not an hour
SETUP = ControllerSetup(57600, (20, 12, 0, 50))
ROBOT = EmulatorSettings(encoder_noise=0.0, slip_sigma=0.0)
Random = np.random.Generator


def _with_number(rng: Random, reply: bytes, _: int) -> bytes:
    return b'%d %d\r\n' % tuple(rng.integers(-(2**31), 2**31, 2)) if _digits(reply) else reply


def _with_digit(rng: Random, reply: bytes, _: int) -> bytes:
    if not _digits(reply):
        return reply
    place = int(rng.choice(_digits(reply)))
    return reply[:place] + b'%d' % rng.integers(10) + reply[place + 1 :]


def _digits(reply: bytes) -> list[int]:
    return [k for k, byte in enumerate(reply) if chr(byte).isdigit()]


def _counts(reply: bytes) -> WheelCounts:
    line = reply.removesuffix(b'\r\n')
    return parse_counts((without_checksum(line) or line) + b'\r\n')


def _without_byte(rng: Random, data: bytes) -> bytes:
    place = int(rng.integers(len(data)))
    return data[:place] + data[place + 1 :]


REPLY_FAULTS: dict[str, Callable[[Random, bytes, int], bytes]] = {
    'silence': lambda _, __, ___: b'',
    'garbage': lambda rng, _, __: rng.bytes(int(rng.integers(1, 90))),
    'cut': lambda _, reply, k: reply[:k] + reply[-2:],
    'no end': lambda _, reply, __: reply[:-2],
    'twice': lambda _, reply, __: reply + reply,
    'flipped bit': lambda rng, reply, k: reply[:k] + bytes([reply[k] ^ (1 << rng.integers(8))]) + reply[k + 1 :],
    'wrong digit': _with_digit,
    'wrong number': _with_number,
    'noise': lambda rng, reply, _: rng.bytes(4) + reply,
}
"""Functions of a reply and a random place in it."""
REQUEST_FAULTS: dict[str, Callable[[Random, bytes], bytes]] = {
    'lost CR': lambda _, data: data.replace(b'\r', b'', 1),
    'lost byte': _without_byte,
    'noise before': lambda rng, data: rng.bytes(3).replace(b'\r', b'x') + data,
}


class CorruptedLine:
    """Bytes to a controller and back; fractions of the replies and of the commands are corrupted.

    Attributes:
        faults: number of faults by kind.
        replies: number of replies of the controller.
        wrong: well-formed counts that differ from those that the controller sent, by what the host got.
        wrong_sent: number of all of them.
    """

    def __init__(self, controller: EmulatedController, rng: Random, fraction: float, request_fraction: float) -> None:
        self._controller, self._rng = controller, rng
        self._share, self._request_share = fraction, request_fraction
        self._received = b''
        self.faults: Counter[str] = Counter()
        self.replies = self.wrong_sent = 0
        self.wrong: dict[WheelCounts, WheelCounts] = {}

    def write(self, data: bytes) -> None:
        """Send a command, sometimes corrupted."""
        if self._rng.random() < self._request_share:
            data = REQUEST_FAULTS[self._choose(REQUEST_FAULTS)](self._rng, data)
        for reply in self._controller.receive(data).splitlines(keepends=True):
            self.replies += 1
            self._received += self._corrupt(reply) if self._rng.random() < self._share else reply

    def read_line(self, size_max: int) -> bytes:
        """Return a line, or what there is."""
        size = min(self._received.find(b'\n') + 1 or size_max, size_max)
        line, self._received = self._received[:size], self._received[size:]
        return line

    def discard_received(self) -> int:
        """Drop everything."""
        count, self._received = len(self._received), b''
        return count

    drain = discard_received

    slowest_reply = 0.0

    def set_latency(self, latency: float) -> None:
        """Nothing is late."""

    def _choose(self, faults: dict[str, Callable[..., bytes]]) -> str:
        kind = list(faults)[self._rng.integers(len(faults))]
        self.faults[kind] += 1
        return kind

    def _corrupt(self, reply: bytes) -> bytes:
        make = REPLY_FAULTS[self._choose(REPLY_FAULTS)]
        corrupted = make(self._rng, reply, int(self._rng.integers(len(reply))))
        try:
            sent, got = _counts(reply), _counts(corrupted)
        except BadReplyError:
            return corrupted
        if sent != got:
            self.wrong_sent += 1
            self.wrong[got] = sent
        return corrupted


class FuzzedDrive:
    """A robot that is driven at random over a corrupted line; fractions as of `CorruptedLine`.

    Attributes:
        line: the line.
        odometry: the odometry of the bridge.
        exceptions: number of exceptions out of the session.
        over_limit: number of commanded wheel speeds beyond the limits.
        wrong_mm: errors of the well-formed wrong counts that odometry accepted: distance of a wheel [mm].
        fastest: greatest commanded wheel speed, as a fraction of the limit.
        jump: greatest excess of an odometry step over the true step [m].
        path: distance of the wheels [m].
    """

    def __init__(
        self, seed: int, fraction: float = 0.05, request_fraction: float = 0.003, firmware: str = ROBOT.firmware
    ) -> None:
        self._rng, settings = np.random.default_rng(seed), DriveSettings()
        self._base = DiffDriveKinematics(settings)
        fastest = Velocity(settings.max_linear_velocity, settings.max_angular_velocity)
        self._limit = max(self._base.to_wheel_ticks(fastest))
        self._controller = EmulatedController(replace(ROBOT, firmware=firmware), self._rng.spawn(1)[0])
        self.line = CorruptedLine(self._controller, self._rng.spawn(1)[0], fraction, request_fraction)
        self._states: list[OdometryState] = []
        self.odometry = EncoderOdometry(self._base, settings)
        drive, report = BaseDrive(self._base, settings, PERIOD), LinkReport(lambda *_: None)
        self._session = ControllerSession(drive, self.odometry, self._now, report, self._states.append)
        self._link, self._over = RosArduinoBridge(self.line, SETUP), Event()
        self._wanted, self._before = Velocity(), self._distance()
        self.exceptions = self.over_limit = 0
        self.fastest = self.jump = self.path = 0.0
        self.wrong_mm: list[float] = []

    def _now(self) -> float:
        return self._controller.time

    def _distance(self) -> float:
        return 0.5 * ROBOT.wheel_radius * sum(self._controller._body.wheel_angles)  # noqa: SLF001 the truth

    def run(self, replies: int) -> None:
        """Drive until the controller has sent so many replies."""
        self._session.connect(self._link, self._over)
        while self.line.replies < replies:
            self._step()

    def _step(self) -> None:
        self._controller.advance(self._now() + PERIOD)
        if self._rng.random() < 0.02:
            self._wanted = Velocity(float(self._rng.normal(0.0, 0.4)), float(self._rng.normal(0.0, 1.0)))
        self._session.drive.set_target(self._wanted, self._now())
        for _ in range(ROUNDS):
            shown = len(self._states)
            try:
                while not self._session.step(self._link, self._over, is_cycle=True):
                    pass
            except Exception:  # noqa: BLE001 it is counted
                self.exceptions += 1
            ticks = max(map(abs, self._base.to_wheel_ticks(self._session.drive.velocity)))
            self.fastest = max(self.fastest, ticks / self._limit)
            self.over_limit += ticks > self._limit + 1e-9
            if len(self._states) > shown:
                self._check_odometry()

    def _check_odometry(self) -> None:
        """Compare the counts that odometry accepted with the true distances of the wheels."""
        accepted = self.odometry._monitor.last_accepted  # noqa: SLF001
        if accepted is None:
            return
        sent = self.line.wrong.get(accepted[0])
        if sent is not None and accepted[1] == self._now():
            wrong = max(abs(accepted[0].left - sent.left), abs(accepted[0].right - sent.right))
            self.wrong_mm.append(1e3 * self._base.metres_per_tick * wrong)
        self.line.wrong.clear()
        true, self._before = abs(self._distance() - self._before), self._distance()
        self.path += true
        if len(self._states) >= 2:
            a, b = self._states[-2].T_odom_base, self._states[-1].T_odom_base
            self.jump = max(self.jump, a.distance_to(b) - true)
        del self._states[:-1]
