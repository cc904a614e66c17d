"""Sets up and runs one mission: nodes, simulation and robot."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from time import monotonic

import numpy as np
from rclpy.executors import Executor

from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.emulator_settings import EmulatorSettings
from motor_bridge.emulator.pseudo_terminal import PseudoTerminal
from scene_simulator.mission_sensors import MissionSensors
from shirube_bringup.building_files import BuildingFiles
from shirube_bringup.free_domain import free_domain
from shirube_bringup.lamp_programs import lamp_waveforms
from shirube_bringup.lockstep_simulator import Simulator
from shirube_bringup.mission import Mission
from shirube_bringup.mission_bag import MissionBag
from shirube_bringup.mission_error import MissionError
from shirube_bringup.mission_record import MissionRecord
from shirube_bringup.mission_subscribers import MissionSubscribers
from shirube_bringup.mission_traces import MissionTraces
from shirube_bringup.node_parameters import NodeSetup, mission_nodes
from shirube_bringup.node_processes import NodeProcesses
from shirube_bringup.render_worker import RenderWorker
from shirube_bringup.sensor_schedule import CAMERAS
from shirube_bringup.simulation_graph import simulation_graph
from shirube_bringup.stopwatch import Stopwatch
from shirube_bringup.trace_recorder import ODOMETRY, TraceRecorder
from shirube_core.geometry import SE2
from vlc_beacon.files.key_file import read_key

_START_TIMEOUT = 600.0
"""Start timeout of the nodes, which load maps and, at the first start, compile numba kernels [s]."""
_WHEELS = 9


PARAMETERS_WRITTEN = 'parameter files are written; waiting for the nodes'
"""Printed when nodes that are launched elsewhere can start."""


@dataclass(frozen=True)
class RunOptions:
    """Options of a mission.

    Attributes:
        record_to: folder of the recorded bag; None records no bag.
        launched: whether the nodes are started elsewhere, on the default ROS domain, with the written parameter files.
    """

    record_to: Path | None = None
    launched: bool = False


@dataclass(frozen=True)
class MissionOutcome:
    """Result of a mission.

    Attributes:
        summary: summary as JSON data.
        traces: time series of the report.
    """

    summary: dict[str, object]
    traces: MissionTraces


def run_mission(
    seed: int,
    files: BuildingFiles,
    folder: Path,
    log: Callable[[str], None],
    options: RunOptions = RunOptions(),
) -> MissionOutcome:
    """Run a mission and return its result.

    Args:
        seed: seed of the room, the robot's errors and all noise.
        files: files of the building.
        folder: existing folder for logs.
        log: called with a line for each event.
        options: whether to record, and whether the nodes are started elsewhere.

    Raises:
        MissionError: a node did not start.
        ReplayError: a node does not respond before the first step.
        BagError: the bag exists, or cannot be written.
    """
    began = monotonic()
    waveforms = lamp_waveforms(read_key(files.key))
    sensors = MissionSensors(seed, waveforms)
    controller, lock = _controller(seed, sensors.layout.start), Lock()
    record = MissionRecord(seed)
    with ExitStack() as stack:
        terminal = stack.enter_context(PseudoTerminal(controller, lock))
        domain, processes = _start_nodes(stack, mission_nodes(files, terminal.path), folder, options, log)
        worker = stack.enter_context(RenderWorker(seed, waveforms))
        node, executor = simulation_graph(stack, domain)
        subscribers, traces = MissionSubscribers(node), TraceRecorder(node)
        steps = Simulator(node, executor, controller, lock, sensors, worker, subscribers, processes.has_ended)
        bag = MissionBag(node, options.record_to, lambda: steps.now) if options.record_to else None
        mission = Mission(
            sensors, controller, subscribers, steps, record, processes, Stopwatch(processes, worker)
        )
        _wait_for_nodes(mission, executor)
        ready = monotonic()
        mission.stopwatch.start()
        log(f'all nodes are ready after {ready - began:.0f} s')
        mission.run(log)
        finished = monotonic()
        mission.stopwatch.stop()
        if bag is not None:
            log(f'recorded {bag.write()} messages in {bag.path}')
    return _make_outcome(
        mission, traces, {'start': ready - began, 'drive': finished - ready, 'whole': monotonic() - began}
    )


def _make_outcome(mission: Mission, recorder: TraceRecorder, timing: Mapping[str, float]) -> MissionOutcome:
    subscribers, record, layout = mission.subscribers, mission.record, mission.sensors.layout
    fixes = {
        name: [(stamped.time, stamped.pose) for stamped in poses] for name, poses in subscribers.fixes.items()
    }
    fixes['pose_arbiter'] = [(stamped.time, stamped.pose) for stamped in subscribers.fused]
    summary = record.summary(len(layout.goals), fixes, subscribers.commands, timing)
    summary['late_steps'] = mission.steps.late_steps
    summary['exit_codes'] = mission.processes.exit_codes
    poses = {
        name: [(time, pose.x, pose.y, pose.yaw) for time, pose in stamped] for name, stamped in fixes.items()
    }
    poses[ODOMETRY] = [
        (stamped.time, stamped.pose.x, stamped.pose.y, stamped.pose.yaw) for stamped in recorder.odometry
    ]
    seconds = max(1e-3 * mission.steps.now, 1e-3)
    traces = MissionTraces(
        layout,
        mission.sensors.room.boxes.boxes,
        record.track,
        record.clearances,
        poses,
        record.legs,
        recorder.trust,
        recorder.map,
        mission.stopwatch.pace,
        mission.stopwatch.cpu,
        {c.name: (1e3 / c.period, mission.steps.publishers.image_counts[c.name] / seconds) for c in CAMERAS},
    )
    return MissionOutcome(summary, traces)


def _start_nodes(
    stack: ExitStack,
    nodes: Sequence[NodeSetup],
    folder: Path,
    options: RunOptions,
    log: Callable[[str], None],
) -> tuple[int, NodeProcesses]:
    """Start the nodes; return their ROS domain and processes, which end with the stack."""
    if options.launched:
        for node in nodes:
            node.arguments(folder)
        log(PARAMETERS_WRITTEN)
        return int(os.environ.get('ROS_DOMAIN_ID', '0')), NodeProcesses((), folder, 0)
    domain = stack.enter_context(free_domain())
    return domain, stack.enter_context(NodeProcesses(nodes, folder, domain))


def _controller(seed: int, start: SE2) -> EmulatedController:
    """Return a controller whose wheels differ slightly from the bridge's parameters."""
    rng = np.random.default_rng((seed, _WHEELS))
    radius, separation = (1.0 + 0.005 * rng.standard_normal(2)).tolist()
    nominal = EmulatorSettings()
    settings = EmulatorSettings(
        wheel_radius=radius * nominal.wheel_radius, wheel_separation=separation * nominal.wheel_separation
    )
    return EmulatedController(settings, rng, start)


def _wait_for_nodes(mission: Mission, executor: Executor) -> None:
    """Wait until every node has subscribed and responds.

    Raises:
        MissionError: timeout.
    """
    end = monotonic() + _START_TIMEOUT
    publishers = mission.steps.publishers
    while unsubscribed := [
        camera.name for camera in CAMERAS if publishers.subscriber_count(camera.name) == 0
    ]:
        mission.processes.check()
        if monotonic() > end:
            raise MissionError(
                f'no subscriber for the images of {", ".join(unsubscribed)}; see the logs of the nodes'
            )
        executor.spin_once(timeout_sec=0.1)
    mission.steps.wait_for_nodes('/floor_localizer', '/vlc_beacon', '/stereo_landmark', '/pose_arbiter')
    mission.steps.wait_for_nodes('/reward_planner', '/motor_bridge')
