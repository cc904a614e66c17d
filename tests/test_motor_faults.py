"""The motor bridge under faults: small versions of its benchmarks."""

import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

pytestmark = pytest.mark.newest_set_only

BENCHMARKS = Path(__file__).resolve().parents[1] / 'benchmarks'


@pytest.fixture(autouse=True)
def benchmarks(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Lets the benchmarks be imported, and shortens what lets other cases follow."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    robot = import_module('_motor_line').Robot
    wait, drive = robot.wait_for_bridge, robot.drive
    # Discovery forgets a killed process after 20 s only; no other one follows here.
    monkeypatch.setattr(robot, 'wait_for_bridge', lambda self, is_there=True: is_there and wait(self))
    monkeypatch.setattr(robot, 'drive', lambda self, seconds, forward: drive(self, min(seconds, 3.0), forward))
    yield
    for name in ('_motor_fuzz', '_motor_line'):
        sys.modules.pop(name, None)


@pytest.mark.parametrize(('seed', 'firmware'), [(1, 'ros_arduino_bridge'), (2, 'motor_controller')])
def test_corrupted_replies_cause_no_wrong_motion(seed: int, firmware: str) -> None:
    drive = import_module('_motor_fuzz').FuzzedDrive(seed, firmware=firmware)
    drive.run(4000)
    assert sum(drive.line.faults.values()) > 100
    assert (drive.exceptions, drive.over_limit) == (0, 0)
    assert drive.jump < 0.02
    assert max(drive.wrong_mm, default=0.0) < (8.0 if firmware == 'ros_arduino_bridge' else 1e-9)


def test_a_line_without_faults_takes_every_count() -> None:
    drive = import_module('_motor_fuzz').FuzzedDrive(3, 0.0, 0.0)
    drive.run(2000)
    assert drive.line.wrong_sent == 0
    statuses = {status.value for status in drive.odometry.status_counts}
    assert statuses <= {'accepted', 'implausible, read again'}
    assert drive.jump < 1e-3


def test_a_terminal_that_is_pulled_away_comes_back() -> None:
    disconnect_terminal = import_module('_motor_line').disconnect_terminal
    back, anew, error = (figure.text for _, figure in disconnect_terminal(3))
    assert (back, anew) == ('3 of 3', '0 of 3')
    assert float(error.split()[0]) < 5.0


@pytest.mark.parametrize(('firmware', 'limit'), [('ros_arduino_bridge', 2.2), ('motor_controller', 1.5)])
def test_a_killed_bridge_leaves_the_motors_to_the_auto_stop(firmware: str, limit: float) -> None:
    kill_bridge = import_module('_motor_line').kill_bridge
    off = kill_bridge(1, firmware)[0][1].text
    assert float(off.split()[0]) < limit


def test_a_held_controller_executes_one_command_at_most_and_then_stops() -> None:
    suspend_controller = import_module('_motor_line').suspend_controller
    acted, stops = (figure.text for _, figure in suspend_controller(1))
    assert int(acted) <= 1
    assert stops == '1 of 1'
