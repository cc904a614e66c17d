"""Serial communication of the motor bridge with the motor controller firmware, without the emulator."""

from collections.abc import Iterator
from pathlib import Path
from threading import Event

import pytest
from simulated_motor_controller import SimulatedMotorController

from motor_bridge.core.base_drive import BaseDrive
from motor_bridge.core.controller_protocol import ControllerSetup
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, DriveSettings, Velocity
from motor_bridge.core.encoder_odometry import EncoderOdometry, OdometryState
from motor_bridge.core.ros_arduino_bridge import RosArduinoBridge
from motor_bridge.link.controller_session import ControllerSession, LinkReport

pytestmark = pytest.mark.newest_set_only

PERIOD = 1.0 / 30.0
REPLY_SECONDS = 0.1
AUTO_STOP = 0.25


class ChipLine:
    """A line to the chip on which time passes only while somebody waits for a reply."""

    slowest_reply = 0.0

    def __init__(self, chip: SimulatedMotorController) -> None:
        self._chip = chip
        self._received = b''

    def set_latency(self, latency: float) -> None:
        """The chip replies at once."""

    def write(self, data: bytes) -> None:
        self._chip.send(data)

    def read_line(self, size_max: int) -> bytes:
        waited = 0.0
        while b'\n' not in self._received and waited < REPLY_SECONDS:
            self._received += self._chip.run(0.001)
            waited += 0.001
        size = min(self._received.find(b'\n') + 1 or size_max, size_max)
        line, self._received = self._received[:size], self._received[size:]
        return line

    def drain(self) -> int:
        count = self.discard_received()
        while more := self._chip.run(0.02):
            count += len(more)
        return count

    def discard_received(self) -> int:
        count, self._received = len(self._received), b''
        return count


class Bridge:
    """The bridge without ROS, in the time of the chip."""

    def __init__(self, chip: SimulatedMotorController) -> None:
        settings = DriveSettings()
        base = DiffDriveKinematics(settings)
        self.chip, self.states = chip, list[OdometryState]()
        self.link = RosArduinoBridge(ChipLine(chip), ControllerSetup(57600, (20, 12, 0, 50), AUTO_STOP))
        self.session = ControllerSession(
            BaseDrive(base, settings, PERIOD),
            EncoderOdometry(base, settings),
            self.now,
            LinkReport(lambda *_: None),
            self.states.append,
        )
        self.session.connect(self.link, Event())

    def now(self) -> float:
        return self.chip.truth().seconds

    def drive(self, velocity: Velocity, seconds: float) -> None:
        end = self.now() + seconds
        while (begun := self.now()) < end:
            self.session.drive.set_target(velocity, begun)
            self.cycle(begun)

    def counts(self) -> tuple[int, int]:
        counts = self.link.read_counts()
        return counts.left, counts.right

    def cycle(self, begun: float) -> None:
        assert self.session.step(self.link, Event(), is_cycle=True)
        self.chip.run(max(0.0, begun + PERIOD - self.now()))


@pytest.fixture
def bridge(motor_firmware: Path) -> Iterator[Bridge]:
    chip = SimulatedMotorController(motor_firmware)
    chip.run(0.1)
    yield Bridge(chip)
    chip.end()


@pytest.mark.parametrize('velocity', [Velocity(-0.2, 0.0), Velocity(0.2, 0.6)])
def test_the_robot_goes_where_it_is_sent_and_odometry_counts_every_tick(bridge: Bridge, velocity: Velocity) -> None:
    bridge.drive(velocity, 1.5)
    before = bridge.states[-1].velocity
    assert before.forward == pytest.approx(velocity.forward, abs=0.02)
    assert before.turn_rate == pytest.approx(velocity.turn_rate, abs=0.1)
    bridge.drive(Velocity(), 1.0)
    assert bridge.session.report.faults.total() == 0
    assert bridge.counts() == bridge.chip.truth().ticks


def test_a_link_without_replies_stops_the_robot_until_they_return(bridge: Bridge) -> None:
    bridge.drive(Velocity(0.3, 0.0), 0.5)
    assert any(bridge.chip.truth().pwm)
    bridge.chip.run(AUTO_STOP + 2e-3)
    assert bridge.chip.truth().pwm == (0, 0)
    bridge.drive(Velocity(0.3, 0.0), 2.0 * PERIOD)
    assert bridge.session.drive.velocity.forward < 0.05  # from rest, within the limits
    bridge.drive(Velocity(0.3, 0.0), 0.5)
    assert any(bridge.chip.truth().pwm)
    bridge.drive(Velocity(), 1.5)
    assert bridge.counts() == bridge.chip.truth().ticks
