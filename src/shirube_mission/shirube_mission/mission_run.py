"""One mission: nodes, simulation and robot together, from goal to goal."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from time import monotonic

import numpy as np
from domain_coordinator import domain_id
from rclpy.executors import SingleThreadedExecutor

from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.emulator_settings import EmulatorSettings
from motor_bridge.emulator.pseudo_terminal import PseudoTerminal
from scene_simulator.disc_clearance import disc_clearance
from scene_simulator.mission_layout import ROBOT_HEIGHT, ROBOT_RADIUS
from scene_simulator.mission_sensors import MissionSensors
from shirube_geometry import PlanarPose
from shirube_mission.building_files import BuildingFiles
from shirube_mission.lamp_programs import lamp_waveforms
from shirube_mission.lock_step import LockStep
from shirube_mission.mission_bag import MissionBag
from shirube_mission.mission_ears import MissionEars
from shirube_mission.mission_error import MissionError
from shirube_mission.mission_record import GoalRecord, MissionRecord
from shirube_mission.mission_traces import MissionTraces
from shirube_mission.node_parameters import NodeSetup, mission_nodes
from shirube_mission.node_processes import NodeProcesses
from shirube_mission.render_worker import RenderWorker
from shirube_mission.sensor_schedule import CAMERAS, STEP_MS
from shirube_mission.simulation_graph import simulation_graph
from shirube_mission.stopwatch import Stopwatch
from shirube_mission.trace_ears import ODOMETRY, TraceEars
from vlc_beacon.files.key_file import read_key

_START_TIMEOUT = 600.0
"""Nodes load maps and, at the very first start, compile their loops [s]."""
_FIRST_POSE, _GOAL_TIME = 10.0, 90.0
"""Longest times until the first pose and from goal to goal, of the mission's time [s]."""
_STANDS = 1.0
"""A robot that has stood so long stands [s]."""
_REACHED = 'goal reached'
_WHEELS = 9


PARAMETERS_WRITTEN = 'parameter files are written; waiting for the nodes'
"""Told when nodes that somebody else starts can be started."""


@dataclass(frozen=True)
class RunOptions:
    """What else can be wanted of a mission.

    Attributes:
        record_to: folder of a bag to make of it; none is made without.
        launched: somebody else starts the nodes, on the usual ROS domain, with the parameter files that are written.
    """

    record_to: Path | None = None
    launched: bool = False


@dataclass
class Mission:
    """A mission that runs.

    Attributes:
        sensors: and the room.
        controller: that moves the robot.
        ears: what the nodes said.
        steps: of time.
        record: what became of it so far.
        processes: of the nodes.
        stopwatch: what the drive costs.
    """

    sensors: MissionSensors
    controller: EmulatedController
    ears: MissionEars
    steps: LockStep
    record: MissionRecord
    processes: NodeProcesses
    stopwatch: Stopwatch

    def go(self, tell: Callable[[str], None]) -> None:
        """Drive to all goals.

        Args:
            tell: is told what happens, a line each time.

        Raises:
            MissionError: a node has ended, or there is no pose.
            ReplayError: a node does not answer.
        """
        self._until(lambda: len(self.ears.fused) > 0, _FIRST_POSE)
        if not self.ears.fused:
            raise MissionError(f'there is no fused pose after {_FIRST_POSE:g} s; see the logs of the nodes')
        self._until(lambda: False, _STANDS)
        for number, goal in enumerate(self.sensors.layout.goals, start=1):
            given = self.steps.now
            record = self._drive_to(goal)
            self.record.goals.append(record)
            self.record.legs.append((1e-3 * given, 1e-3 * self.steps.now))
            tell(
                f'goal {number} {"reached" if record.reached else "NOT reached"} after {record.seconds:.1f} s: true '
                f'pose {1e3 * record.true_error:.1f} mm off, fused pose {1e3 * record.fused_error:.1f} mm'
            )
            if not record.reached:
                self.record.ended = f'goal {number} was not reached: {self.ears.planner[1]}'
                return
        self.record.ended = 'all goals were reached'

    def _drive_to(self, goal: PlanarPose) -> GoalRecord:
        start = self.steps.now
        self.steps.voice.send_to(start, goal)
        stood = 0

        def is_there() -> bool:
            nonlocal stood
            stood = stood + STEP_MS if self.controller.is_stopped else 0
            heard, does = self.ears.planner
            return does == _REACHED and heard > 1e-3 * start + 0.5 and stood >= 1e3 * _STANDS

        reached = self._until(is_there, _GOAL_TIME)
        truth = self.controller.T_world_base
        fused = self.ears.fused[-1]
        then = self.controller.pose_at(fused.time)
        return GoalRecord(
            reached,
            1e-3 * (self.steps.now - start),
            truth.distance_to(goal),
            abs(truth.turn_to(goal)),
            fused.pose.distance_to(then),
        )

    def _until(self, is_over: Callable[[], bool], seconds: float) -> bool:
        """Let time pass until something is so; return whether it is, after so long at most [s]."""
        end = self.steps.now + round(1e3 * seconds)
        while self.steps.now < end:
            self.steps.step()
            self.processes.check()
            pose = self.controller.T_world_base
            room = disc_clearance(self.sensors.room.boxes, pose.x, pose.y, ROBOT_RADIUS, ROBOT_HEIGHT)
            self.record.add_step(1e-3 * self.steps.now, pose, room)
            self.stopwatch.look(1e-3 * self.steps.now)
            if is_over():
                return True
        return False


@dataclass(frozen=True)
class MissionOutcome:
    """What became of a mission.

    Attributes:
        summary: in a few numbers, ready for JSON.
        traces: all of it.
    """

    summary: dict[str, object]
    traces: MissionTraces


def run_mission(
    seed: int,
    files: BuildingFiles,
    folder: Path,
    tell: Callable[[str], None],
    options: RunOptions = RunOptions(),
) -> MissionOutcome:
    """Run a mission.

    Args:
        seed: of the room, the robot's errors and all noise.
        files: what the robot knows of the building.
        folder: takes logs; it is there.
        tell: is told what happens, a line each time.
        options: whether it is recorded, and who starts the nodes.

    Returns:
        what became of it.

    Raises:
        MissionError: a node did not start, ended, or there is no pose.
        ReplayError: a node does not answer.
        BagError: the bag stands there already, or cannot be written.
    """
    began = monotonic()
    waveforms = lamp_waveforms(read_key(files.key))
    sensors = MissionSensors(seed, waveforms)
    controller, lock = _controller(seed, sensors.layout.start), Lock()
    record = MissionRecord(seed)
    with ExitStack() as stack:
        terminal = stack.enter_context(PseudoTerminal(controller, lock))
        domain, processes = _nodes(stack, mission_nodes(files, terminal.path), folder, options, tell)
        worker = stack.enter_context(RenderWorker(seed, waveforms))
        node, executor = simulation_graph(stack, domain)
        ears, traces = MissionEars(node), TraceEars(node)
        steps = LockStep(node, executor, controller, lock, sensors, worker, ears)
        bag = MissionBag(node, options.record_to, lambda: steps.now) if options.record_to else None
        mission = Mission(sensors, controller, ears, steps, record, processes, Stopwatch(processes, worker))
        _await_nodes(mission, executor)
        ready = monotonic()
        mission.stopwatch.start()
        tell(f'all nodes are ready after {ready - began:.0f} s')
        mission.go(tell)
        over = monotonic()
        mission.stopwatch.stop()
        if bag is not None:
            tell(f'recorded {bag.write()} messages in {bag.path}')
    return _outcome(
        mission, traces, {'start': ready - began, 'drive': over - ready, 'whole': monotonic() - began}
    )


def _outcome(mission: Mission, heard: TraceEars, timing: Mapping[str, float]) -> MissionOutcome:
    ears, record, layout = mission.ears, mission.record, mission.sensors.layout
    fixes = {name: [(told.time, told.pose) for told in poses] for name, poses in ears.fixes.items()}
    fixes['pose_arbiter'] = [(told.time, told.pose) for told in ears.fused]
    summary = record.summary(len(layout.goals), fixes, ears.orders, timing)
    summary['late_steps'] = mission.steps.late_steps
    summary['exit_codes'] = mission.processes.exit_codes
    poses = {name: [(time, pose.x, pose.y, pose.yaw) for time, pose in told] for name, told in fixes.items()}
    poses[ODOMETRY] = [(told.time, told.pose.x, told.pose.y, told.pose.yaw) for told in heard.odometry]
    seconds = max(1e-3 * mission.steps.now, 1e-3)
    traces = MissionTraces(
        layout,
        mission.sensors.room.boxes.boxes,
        record.track,
        record.clearances,
        poses,
        record.legs,
        heard.trust,
        heard.map,
        mission.stopwatch.pace,
        mission.stopwatch.cpu,
        {c.name: (1e3 / c.period, mission.steps.voice.shown[c.name] / seconds) for c in CAMERAS},
    )
    return MissionOutcome(summary, traces)


def _nodes(
    stack: ExitStack,
    nodes: Sequence[NodeSetup],
    folder: Path,
    options: RunOptions,
    tell: Callable[[str], None],
) -> tuple[int, NodeProcesses]:
    """Return the ROS domain and the nodes that were started there, which end with the stack."""
    if options.launched:
        for node in nodes:
            node.arguments(folder)
        tell(PARAMETERS_WRITTEN)
        return int(os.environ.get('ROS_DOMAIN_ID', '0')), NodeProcesses((), folder, 0)
    domain = stack.enter_context(domain_id())
    return domain, stack.enter_context(NodeProcesses(nodes, folder, domain))


def _controller(seed: int, start: PlanarPose) -> EmulatedController:
    """Return a robot whose wheels are not quite what the bridge takes them for."""
    rng = np.random.default_rng((seed, _WHEELS))
    radius, separation = (1.0 + 0.005 * rng.standard_normal(2)).tolist()
    nominal = EmulatorSettings()
    settings = EmulatorSettings(
        wheel_radius=radius * nominal.wheel_radius, wheel_separation=separation * nominal.wheel_separation
    )
    return EmulatedController(settings, rng, start)


def _await_nodes(mission: Mission, executor: SingleThreadedExecutor) -> None:
    """Wait until every node listens and answers.

    Raises:
        MissionError: one does not in time.
    """
    end = monotonic() + _START_TIMEOUT
    voice = mission.steps.voice
    while silent := [camera.name for camera in CAMERAS if voice.listeners(camera.name) == 0]:
        mission.processes.check()
        if monotonic() > end:
            raise MissionError(
                f'nobody listens to the pictures of {", ".join(silent)}; see the logs of the nodes'
            )
        executor.spin_once(timeout_sec=0.1)
    mission.steps.ask('/floor_localizer', '/vlc_beacon', '/stereo_landmark', '/pose_arbiter')
    mission.steps.ask('/reward_planner', '/motor_bridge')
