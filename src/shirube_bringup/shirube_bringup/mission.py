"""Runs a mission: from goal to goal, step by step, until all are reached or a node fails."""

from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic, process_time

from scene_simulator.mission.layout import ROBOT_HEIGHT, ROBOT_RADIUS
from scene_simulator.mission.sensors import MissionSensors
from scene_simulator.room.box_room import disc_clearance
from shirube_bags.errors import ReplayError
from shirube_bringup.nodes import MissionError, NodeProcesses
from shirube_bringup.record import GoalRecord, MissionRecord
from shirube_bringup.render_worker import RenderWorker
from shirube_bringup.simulator import KIDNAPPING, RECOVERED_WITHIN, RECOVERY_TIME, STEP_MS, CarriedController, Simulator
from shirube_bringup.topics import MissionSubscribers, StampedPose
from shirube_core.geometry import SE2

_FIRST_POSE, _GOAL_TIME, _GOAL_TIME_AMONG_PEOPLE = 10.0, 90.0, 180.0
"""Timeouts for the first pose and for each goal, also while people walk around, in mission time [s]."""

_STATIONARY_TIME = 1.0  # a robot without motion for this long is stationary [s]
_REACHED = 'goal reached'


class Stopwatch:
    """Measures wall time and CPU times during the drive.

    Attributes:
        pace: simulated time and wall time since the start [s], about once per simulated second.
        cpu: CPU time of each process [s], after `stop`.
    """

    def __init__(self, processes: NodeProcesses, worker: RenderWorker) -> None:
        """Start without measurements."""
        self.pace: list[tuple[float, float]] = []
        self.cpu: dict[str, float] = {}
        self._processes, self._worker = processes, worker
        self._began, self._cpu_at_start = monotonic(), dict[str, float]()

    def start(self) -> None:
        """Start the measurement."""
        self._began, self._cpu_at_start = monotonic(), self._cpu_times()

    def record_time(self, now: float) -> None:
        """Record the wall time at a mission time [s]."""
        if not self.pace or now >= self.pace[-1][0] + 1.0:
            self.pace.append((now, monotonic() - self._began))

    def stop(self) -> None:
        """Compute the CPU times since the start."""
        self.cpu = {name: time - self._cpu_at_start[name] for name, time in self._cpu_times().items()}

    def _cpu_times(self) -> dict[str, float]:
        others = {'pictures': self._worker.cpu_time(), 'simulation': process_time()}
        return {**self._processes.cpu_times(), **others}


@dataclass
class Mission:
    """A running mission.

    Attributes:
        sensors: simulated sensors and room.
        controller: emulated controller that moves the robot.
        subscribers: messages received from the nodes.
        steps: lockstep simulation.
        record: result so far.
        processes: processes of the nodes.
        stopwatch: timing of the drive.
        is_kidnapped: whether the robot is carried away at the first goal.
    """

    sensors: MissionSensors
    controller: CarriedController
    subscribers: MissionSubscribers
    steps: Simulator
    record: MissionRecord
    processes: NodeProcesses
    stopwatch: Stopwatch
    is_kidnapped: bool = False

    def run(self, log: Callable[[str], None]) -> None:
        """Drive to all goals; if a node ends or hangs, the drive ends and the record gives the reason.

        Args:
            log: called with a line for each event.

        Raises:
            MissionError: a node has ended before the first step.
            ReplayError: a node does not respond before the first step.
        """
        try:
            self._visit_goals(log)
        except (MissionError, ReplayError) as fault:
            if not self.record.track:
                raise
            self.record.ended = str(fault)

    def _visit_goals(self, log: Callable[[str], None]) -> None:
        self._step_until(lambda: len(self.subscribers.fused) > 0, _FIRST_POSE)
        if not self.subscribers.fused:
            raise MissionError(f'no fused pose after {_FIRST_POSE:g} s; see the logs of the nodes')
        self._step_until(lambda: False, _STATIONARY_TIME)
        for number, goal in enumerate(self.sensors.layout.goals, start=1):
            given = self.steps.now
            record = self._drive_to(goal)
            self.record.goals.append(record)
            self.record.legs.append((1e-3 * given, 1e-3 * self.steps.now))
            log(
                f'goal {number} {"reached" if record.reached else "NOT reached"} after {record.seconds:.1f} s: true '
                f'pose {1e3 * record.true_error:.1f} mm off, fused pose {1e3 * record.fused_error:.1f} mm'
            )
            if not record.reached:
                self.record.ended = f'goal {number} was not reached: {self.subscribers.planner[1]}'
                return
            if self.is_kidnapped and number == 1:
                self._kidnap(log)
        self.record.ended = 'all goals were reached'

    def _kidnap(self, log: Callable[[str], None]) -> None:
        """Carry the robot away and wait until the fused pose is right; the floor localizer is on the carpet."""
        start, areas = self.steps.now, len(self.subscribers.areas)
        self.controller.carry_to(self.controller.T_world_base @ KIDNAPPING)

        def has_recovered() -> bool:
            time, pose = self.subscribers.fused[-1]
            is_new = time > 1e-3 * start
            return is_new and pose.distance_to(self.controller.pose_at(time)) < RECOVERED_WITHIN

        recovered = self._step_until(has_recovered, RECOVERY_TIME)
        end = self.steps.now
        self._step_until(lambda: len(self.subscribers.areas) > areas, 1.0)
        self.record.kidnapping = {
            'time': 1e-3 * start,
            'recovered_after': 1e-3 * (end - start) if recovered else None,
            'areas': [(area.time, *_error(area, self.controller)) for area in self.subscribers.areas[areas:]],
        }
        log(f'kidnapped: {self.record.kidnapping}')

    def _drive_to(self, goal: SE2) -> GoalRecord:
        start = self.steps.now
        self.steps.publishers.publish_goal(start, goal)
        stationary_ms = 0

        def is_goal_done() -> bool:
            nonlocal stationary_ms
            stationary_ms = stationary_ms + STEP_MS if self.controller.is_stopped else 0
            status_time, status = self.subscribers.planner
            # An earlier status may be based on a pose that was corrected since.
            is_fresh = status_time >= 1e-3 * (self.steps.now - stationary_ms) + _STATIONARY_TIME
            return status == _REACHED and status_time > 1e-3 * start + 0.5 and is_fresh

        timeout = _GOAL_TIME_AMONG_PEOPLE if self.steps.people else _GOAL_TIME
        reached = self._step_until(is_goal_done, timeout)
        truth = self.controller.T_world_base
        fused = self.subscribers.fused[-1]
        then = self.controller.pose_at(fused.time)
        seconds, fused_error = 1e-3 * (self.steps.now - start), fused.pose.distance_to(then)
        return GoalRecord(reached, seconds, truth.distance_to(goal), abs(truth.yaw_to(goal)), fused_error)

    def _step_until(self, is_done: Callable[[], bool], seconds: float) -> bool:
        """Step until a condition is true; return False after a timeout [s]."""
        end = self.steps.now + round(1e3 * seconds)
        while self.steps.now < end:
            self.steps.step()
            self.processes.check()
            pose = self.controller.T_world_base
            room = disc_clearance(self.sensors.room.boxes, pose.x, pose.y, ROBOT_RADIUS, ROBOT_HEIGHT)
            people = [person.place for person in self.steps.people]
            self.record.add_step(1e-3 * self.steps.now, pose, room, people)
            self.stopwatch.record_time(1e-3 * self.steps.now)
            if is_done():
                return True
        return False


def _error(area: StampedPose, controller: CarriedController) -> tuple[float, float]:
    """Return the errors of an area's centre: distance [m] and yaw [rad]."""
    truth = controller.pose_at(area.time)
    return area.pose.distance_to(truth), abs(area.pose.yaw_to(truth))
