"""In lockstep no message is lost or early, and the robot's time is that of the clock."""

from __future__ import annotations

from functools import partial
from threading import Lock

import numpy as np
import pytest
from node_testing import isolated_graph
from rclpy.node import Node
from stand_in_nodes import TOPICS, StubNode

from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.emulator_settings import EmulatorSettings
from scene_simulator.mission_lamps import LAMPS
from scene_simulator.mission_sensors import MissionSensors
from shirube_bringup.lockstep_simulator import Simulator
from shirube_bringup.mission_subscribers import MissionSubscribers
from shirube_bringup.sensor_schedule import CAMERAS, STEP_MS
from shirube_core.waveform import steady_light

STEPS = 90
SIZES = {'floor': (235, 235), 'ceiling': (384, 480), 'stereo': (480, 752), 'depth': (120, 160)}


class BlackPictures:
    """Renders black images and stores the requests."""

    def __init__(self):
        self.requested: dict[tuple[str, int], object] = {}

    def request(self, sensor, index, time, path):
        self.requested[sensor, index] = time, path

    def collect(self, sensor, index):
        assert (sensor, index) in self.requested
        kind = np.float32 if sensor == 'depth' else np.uint8
        return [np.zeros(SIZES[sensor], kind)] * (2 if sensor == 'stereo' else 1)


@pytest.fixture(scope='module')
def run():
    """Run some steps with stubs for all nodes."""
    with isolated_graph() as graph:
        nodes = {name: graph.add(partial(StubNode, name)) for name in TOPICS}
        node = graph.add(partial(Node, 'scene_simulator'))
        controller = EmulatedController(EmulatorSettings(), np.random.default_rng(0))
        sensors = MissionSensors(0, {name: steady_light() for name in LAMPS})
        worker, subscribers = BlackPictures(), MissionSubscribers(node)
        steps = Simulator(node, graph._executor, controller, Lock(), sensors, worker, subscribers)
        assert graph.spin_until(
            lambda: all(steps.publishers.subscriber_count(camera.name) for camera in CAMERAS)
        )
        for _ in range(STEPS):
            steps.step()
        yield nodes, steps, controller, worker


def test_every_picture_arrives_in_its_order(run):
    nodes, steps, _, _ = run
    for camera, listener in zip(
        CAMERAS, ('floor_localizer', 'vlc_beacon', 'stereo_landmark', 'reward_planner')
    ):
        due = [1e-3 * camera.time_ms(index) for index in camera.indices(0, steps.now, camera.latency)]
        assert due
        for topic in TOPICS[listener]:
            stamps = [stamp for name, stamp, _ in nodes[listener].received if name == topic]
            assert stamps == pytest.approx(due)


def test_no_picture_comes_before_its_latency(run):
    nodes, _, _, _ = run
    latency = {'floor_localizer': 60, 'vlc_beacon': 60, 'stereo_landmark': 200, 'reward_planner': 80}
    for name, milliseconds in latency.items():
        for _, stamp, clock_time in nodes[name].received:
            assert clock_time + 1e-3 * STEP_MS >= stamp + 1e-3 * milliseconds - 1e-9


def test_the_clock_goes_in_even_steps_and_is_the_robots_time(run):
    nodes, steps, controller, _ = run
    times = nodes['motor_bridge'].clock_times
    assert np.diff(times) == pytest.approx(1e-3 * STEP_MS)
    assert times[-1] == pytest.approx(1e-3 * STEPS * STEP_MS)
    assert controller.time == pytest.approx(times[-1])
    assert steps.late_steps <= 1  # the first one, before all publishers are discovered


def test_paths_cover_exposures(run):
    _, _, _, worker = run
    for (sensor, _), (time, path) in worker.requested.items():
        exposure = {'floor': 0.00075, 'ceiling': 0.0073}.get(sensor, 0.0)
        assert path.times[0] <= time + 1e-9
        assert path.times[-1] >= time + exposure - 1e-9
