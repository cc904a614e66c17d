"""Sets up and runs one mission: nodes, simulation and robot."""

import os
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from threading import Lock
from time import monotonic
from typing import Any

import numpy as np
import rclpy
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from motor_bridge.emulator.firmware import EmulatorSettings
from motor_bridge.emulator.pseudo_terminal import PseudoTerminal
from scene_simulator.mission.pedestrians import mission_pedestrians
from scene_simulator.mission.sensors import MissionSensors
from shirube_bringup.bag import MissionBag
from shirube_bringup.building import BuildingFiles, lamp_waveforms
from shirube_bringup.free_domain import free_domain
from shirube_bringup.mission import Mission, Stopwatch
from shirube_bringup.nodes import MissionError, NodeProcesses, NodeSetup, mission_nodes
from shirube_bringup.record import MissionRecord, MissionTraces
from shirube_bringup.render_worker import RenderWorker
from shirube_bringup.simulator import CAMERAS, SUBSCRIBERS, CarriedController, Simulator
from shirube_bringup.topics import ODOMETRY, MissionSubscribers
from shirube_core.geometry import SE2
from shirube_ros.node import node_executor
from vlc_beacon.files.authorization_files import read_key

_START_TIMEOUT = 600.0  # start timeout of the nodes, which load maps and, at the first start, compile numba kernels [s]
_WHEELS = 9
PARAMETERS_WRITTEN = 'parameter files are written; waiting for the nodes'
"""Printed when nodes that are launched elsewhere can start."""


def simulation_graph(stack: ExitStack, domain: int) -> tuple[Node, Executor]:
    """Create the simulation's node and its executor, both destroyed with the stack."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
    stack.callback(context.try_shutdown)
    node = Node('scene_simulator', context=context)
    stack.callback(node.destroy_node)
    executor = node_executor(context)
    stack.callback(executor.shutdown)
    executor.add_node(node)
    return node, executor


def run_mission(
    seed: int,
    files: BuildingFiles,
    folder: Path,
    log: Callable[[str], None],
    record_to: Path | None = None,
    *,
    launched: bool = False,
    planner: str = 'default',
    is_kidnapped: bool = False,
    people: int = 0,
    domain: int | None = None,
) -> tuple[dict[str, Any], MissionTraces]:
    """Run a mission and return its summary, as JSON data, and its time series.

    Args:
        seed: seed of the room, the robot's errors and all noise.
        files: files of the building.
        folder: existing folder for logs.
        log: called with a line for each event.
        record_to: folder of the recorded bag; None records no bag.
        launched: whether the nodes are started elsewhere, on the default domain; their parameter files are written.
        planner: one of `PLANNERS`.
        is_kidnapped: whether the robot is carried away at the first goal.
        people: number of people who walk in the room.
        domain: ROS domain of the nodes; None reserves a free one.

    Raises:
        MissionError, ReplayError: a node did not start, or does not respond before the first step.
        BagError: the bag exists, or cannot be written.
    """
    began, waveforms = monotonic(), lamp_waveforms(read_key(files.key))
    sensors, lock = MissionSensors(seed, waveforms), Lock()
    walking = mission_pedestrians(seed, people, sensors.room, sensors.layout)
    controller = _controller(seed, sensors.layout.start)
    with ExitStack() as stack:
        setups = mission_nodes(files, stack.enter_context(PseudoTerminal(controller, lock)).path, planner)
        domain, nodes = _start_nodes(stack, setups, folder, log, domain, launched=launched)
        worker = stack.enter_context(RenderWorker(seed, waveforms))
        node, executor = simulation_graph(stack, domain)
        received = MissionSubscribers(node)
        given = node, executor, controller, lock, sensors, worker, received
        steps = Simulator(*given, nodes.has_ended, walking)
        bag = MissionBag(node, record_to, lambda: steps.now) if record_to else None
        parts = sensors, controller, received, steps, MissionRecord(seed), nodes
        mission = Mission(*parts, Stopwatch(nodes, worker), is_kidnapped)
        ready, finished = _drive(mission, executor, log, began)
        if bag:
            log(f'recorded {bag.write()} messages in {bag.path}')
    return _make_outcome(mission, began, ready, finished)


def _drive(mission: Mission, executor: Executor, log: Callable[[str], None], began: float) -> tuple[float, float]:
    """Drive the mission once all nodes are ready; return the times of its start and end [s]."""
    _wait_for_nodes(mission, executor)
    mission.stopwatch.start()
    log(f'all nodes are ready after {(ready := monotonic()) - began:.0f} s')
    mission.run(log)
    finished = monotonic()
    mission.stopwatch.stop()
    return ready, finished


def _make_outcome(
    mission: Mission, began: float, ready: float, finished: float
) -> tuple[dict[str, Any], MissionTraces]:
    timing = {'start': ready - began, 'drive': finished - ready, 'whole': monotonic() - began}
    subscribers, record, layout = mission.subscribers, mission.record, mission.sensors.layout
    stamped = {**subscribers.fixes, 'pose_arbiter': subscribers.fused, ODOMETRY: subscribers.odometry}
    poses = {name: [(time, pose.x, pose.y, pose.yaw) for time, pose in each] for name, each in stamped.items()}
    fixes = {name: each for name, each in poses.items() if name != ODOMETRY}
    summary = record.summary(len(layout.goals), fixes, subscribers.commands, timing)
    summary['late_steps'] = mission.steps.late_steps
    summary['exit_codes'] = mission.processes.exit_codes
    seconds = max(1e-3 * mission.steps.now, 1e-3)
    traces = MissionTraces(
        layout,
        mission.sensors.room.boxes.boxes,
        record.track,
        record.clearances,
        poses,
        record.legs,
        subscribers.trust,
        subscribers.map,
        mission.stopwatch.pace,
        mission.stopwatch.cpu,
        {c.name: (1e3 / c.period, mission.steps.publishers.image_counts[c.name] / seconds) for c in CAMERAS},
        record.people,
    )
    return summary, traces


def _start_nodes(
    stack: ExitStack,
    nodes: Sequence[NodeSetup],
    folder: Path,
    log: Callable[[str], None],
    domain: int | None,
    *,
    launched: bool,
) -> tuple[int, NodeProcesses]:
    """Start the nodes; return their ROS domain and processes, which end with the stack."""
    if launched:
        for node in nodes:
            node.arguments(folder)
        log(PARAMETERS_WRITTEN)
        return int(os.environ.get('ROS_DOMAIN_ID', '0')), NodeProcesses((), folder, 0)
    domain = stack.enter_context(free_domain()) if domain is None else domain
    return domain, stack.enter_context(NodeProcesses(nodes, folder, domain))


def _controller(seed: int, start: SE2) -> CarriedController:
    """Return a controller whose wheels differ slightly from the bridge's parameters."""
    rng = np.random.default_rng((seed, _WHEELS))
    radius, separation = (1.0 + 0.005 * rng.standard_normal(2)).tolist()
    nominal = EmulatorSettings()
    settings = EmulatorSettings(
        wheel_radius=radius * nominal.wheel_radius, wheel_separation=separation * nominal.wheel_separation
    )
    return CarriedController(settings, rng, start)


def _wait_for_nodes(mission: Mission, executor: Executor) -> None:
    """Wait until every node has subscribed and responds, or raise a MissionError."""
    end = monotonic() + _START_TIMEOUT
    publishers = mission.steps.publishers
    while unsubscribed := [
        name for name, nodes in SUBSCRIBERS.items() if publishers.subscriber_count(name) < len(nodes)
    ]:
        mission.processes.check()
        if monotonic() > end:
            raise MissionError(f'no subscriber for the images of {", ".join(unsubscribed)}; see the logs of the nodes')
        executor.spin_once(timeout_sec=0.1)
    mission.steps.wait_for_nodes('/floor_localizer', '/vlc_beacon', '/stereo_landmark', '/pose_arbiter')
    mission.steps.wait_for_nodes('/reward_planner', '/collision_monitor', '/motor_bridge')
