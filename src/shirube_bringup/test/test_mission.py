"""An aborted mission keeps its record, with the reason."""

from types import SimpleNamespace

import numpy as np
import pytest

from motor_bridge.emulator.firmware import EmulatorSettings
from scene_simulator.mission.sensors import MissionSensors
from shirube_bags.errors import ReplayError
from shirube_bringup.mission import Mission
from shirube_bringup.nodes import MissionError
from shirube_bringup.record import MissionRecord
from shirube_bringup.simulator import KIDNAPPING, STEP_MS, CarriedController
from shirube_bringup.topics import StampedPose
from shirube_core.geometry import SE2

SEED = 3
FUSED = [StampedPose(0.0, SE2(0.0, 0.0, 0.0))]


class FakeSimulation:
    """A simulation of some steps, after which a node does not respond; it ignores the goals."""

    def __init__(self, count: int) -> None:
        self.now, self.left, self.people = 0, count, ()
        self.publishers = SimpleNamespace(publish_goal=lambda _now, _goal: None)

    def step(self) -> None:
        if self.left == 0:
            raise ReplayError('/vlc_beacon has not responded for 60 s; check whether it hangs')
        self.left -= 1
        self.now += STEP_MS


def mission(steps: int, looks: int) -> Mission:
    """Return a mission with a fused pose from the start and no goal reached; a node ends after some looks at it."""
    left = iter(range(looks))

    def check() -> None:
        if next(left, None) is None:
            raise MissionError('vlc_beacon ended with exit code -9; see vlc_beacon.log')

    sensors = MissionSensors(SEED, {})
    controller = CarriedController(EmulatorSettings(), np.random.default_rng(0), sensors.layout.start)
    return Mission(
        sensors,
        controller,
        SimpleNamespace(fused=FUSED, planner=(0.0, 'driving to the goal')),
        FakeSimulation(steps),
        MissionRecord(SEED),
        SimpleNamespace(check=check),
        SimpleNamespace(record_time=lambda _: None),
    )


@pytest.mark.parametrize(
    ('steps', 'looks', 'reason'), [(70, 500, 'has not responded'), (500, 70, 'ended with exit code -9')]
)
def test_a_node_that_hangs_or_ends_leaves_a_record_with_the_reason(steps, looks, reason):
    broken = mission(steps, looks)
    broken.run(print)
    assert reason in broken.record.ended
    assert 'vlc_beacon' in broken.record.ended
    assert len(broken.record.track) == 70
    assert not broken.record.has_succeeded(3)


@pytest.mark.parametrize(('steps', 'looks'), [(0, 500), (500, 0)])
def test_an_error_before_the_first_step_is_raised(steps, looks):
    with pytest.raises((MissionError, ReplayError)):
        mission(steps, looks).run(print)


class StoppingController:
    """A controller that stops at a time [s]."""

    T_world_base = SE2(0.0, 0.0, 0.0)

    def __init__(self, steps: FakeSimulation, time: float) -> None:
        self.steps, self.time = steps, time

    @property
    def is_stopped(self) -> bool:
        return 1e-3 * self.steps.now >= self.time

    def pose_at(self, _: float) -> SE2:
        return self.T_world_base


class FakePlannerStatus:
    """A planner status each second: goal reached, except for one second, when the pose was corrected."""

    fused = FUSED

    def __init__(self, steps: FakeSimulation, corrected: int) -> None:
        self.steps, self.corrected = steps, corrected

    @property
    def planner(self) -> tuple[float, str]:
        second = self.steps.now // 1000
        return float(second), 'driving' if second == self.corrected else 'goal reached'


@pytest.mark.parametrize(('corrected', 'seconds'), [(3, 3.0), (4, 4.0), (5, 3.0)])
def test_a_goal_is_reached_when_the_planner_still_says_so_a_second_after_the_halt(corrected, seconds):
    """The first goal is published at 1 s and the wheels stop at 2.5 s: the status of second 4 is the first valid."""
    driven = mission(8000 // STEP_MS, 8000)
    driven.controller = StoppingController(driven.steps, 2.5)
    driven.subscribers = FakePlannerStatus(driven.steps, corrected)
    driven.run(print)
    assert driven.record.goals[0].reached
    assert driven.record.goals[0].seconds == pytest.approx(seconds, abs=0.1)


def test_a_carried_robot_is_elsewhere_from_then_on_and_its_wheels_do_not_notice():
    sensors = MissionSensors(SEED, {})
    here = sensors.layout.start
    robot = CarriedController(EmulatorSettings(), np.random.default_rng(0), here)
    robot.advance(1.0)
    before = robot.receive(b'e\r')
    robot.carry_to(here @ KIDNAPPING)
    assert robot.receive(b'e\r') == before
    assert robot.pose_at(0.9) == here
    robot.receive(b'm 20 20\r')
    robot.advance(2.0)
    driven = (here @ KIDNAPPING).inverse() @ robot.T_world_base
    assert driven.x > 0.01
    assert abs(driven.y) < 0.1 * driven.x


def test_a_kidnapped_robot_records_when_it_recovered_and_the_areas():
    kidnapped = mission(2000, 2000)
    kidnapped.subscribers = SimpleNamespace(fused=FUSED, areas=[])
    kidnapped._kidnap(print)
    assert kidnapped.record.kidnapping['recovered_after'] is None
    there = kidnapped.controller.T_world_base @ KIDNAPPING
    kidnapped.controller.pose_at = lambda _: there
    kidnapped.subscribers.fused = [StampedPose(1e9, there)]
    kidnapped._kidnap(print)
    assert kidnapped.record.kidnapping['recovered_after'] == pytest.approx(1e-3 * STEP_MS)
