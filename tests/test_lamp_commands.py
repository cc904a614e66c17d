"""The paper's run (3.3, figure 4) in closed loop at its scale: commands reach the moving robot and steer it."""

import math
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from shirube_core.geometry import SE2
from vlc_beacon.core.packet.command_packet import Operation

pytestmark = [pytest.mark.newest_set_only, pytest.mark.timeout(600)]

BENCHMARK = '_lamp_commands'
CRUISE = 0.4


@pytest.fixture(scope='module')
def run(bench: ModuleType) -> list[Any]:
    """The images of a run with lamps of 6.5 cm at 2.5 m; nothing is commanded before the robot moves."""
    return list(bench.drive(bench.RS_FSK_60, CRUISE, 22.5))


def test_the_moving_robot_obeys_the_lamps_in_their_zones(bench: ModuleType, run: list[Any]) -> None:
    said = [(command, instant) for instant in run for command in instant.commands]
    a, b = (
        [(bench.A, o) for o in (Operation.SLOW, Operation.TURN)],
        [(bench.B, o) for o in (Operation.TURN, Operation.SPEED_UP)],
    )
    assert sorted(command for command, _ in said) == sorted([*a, *b])
    assert {command for command, _ in said[:2]} == set(a)
    for (lamp, _), instant in said:
        x, y, _ = bench.BEACONS[lamp - 1].xyz
        assert math.dist((instant.pose.x, instant.pose.y), (x, y)) < bench.AUTHORIZATION.zone_radius + 0.05
    assert said[0][1].velocity.forward > 0.8 * CRUISE


def test_it_turns_right_twice_slow_in_between_and_leaves_faster(run: list[Any]) -> None:
    between = [instant.velocity.forward for instant in run if 0.6 < instant.pose.y < 1.2]
    assert np.median(between) == pytest.approx(0.5 * CRUISE)
    assert max(instant.velocity.forward for instant in run) <= CRUISE + 1e-9
    end = run[-1]
    assert abs(end.pose.yaw_to(SE2(0.0, 0.0, math.pi))) < 0.03
    assert end.velocity.forward == pytest.approx(CRUISE)
    assert end.pose.x < 1.6
    assert abs(end.pose.y) < 0.35


def test_its_poses_are_right_all_the_way(run: list[Any]) -> None:
    errors = np.array([instant.error for instant in run if instant.velocity.forward > 0.0])
    assert np.isfinite(errors).mean() > 0.99
    assert np.nanmedian(errors) < 0.005
    assert np.nanmax(errors) < 0.02
