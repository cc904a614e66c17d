"""In lockstep no message is lost or early, and the robot's time is that of the clock."""

from functools import partial
from threading import Lock

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from node_testing import isolated_graph
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.firmware import EmulatorSettings
from scene_simulator.mission.layout import LAMPS
from scene_simulator.mission.sensors import MissionSensors
from shirube_bringup.simulator import CAMERAS, STEP_MS, TILT, SensorSchedule, Simulator
from shirube_bringup.topics import MissionSubscribers, mission_time
from shirube_core.waveform import steady_light


@pytest.mark.parametrize('schedule', [*CAMERAS, TILT, SensorSchedule('odd', 33, 7, 5, 50)])
@pytest.mark.parametrize('step', [1, 7, STEP_MS, 50])
def test_all_come_once(schedule, step):
    end = 2000
    steps = [(now - step, now) for now in range(step, end + step, step)]
    shown = [index for before, now in steps for index in schedule.indices(before, now, schedule.latency)]
    assert shown == list(range(len(shown)))
    last = schedule.time_ms(len(shown)) + schedule.latency
    assert last > end


@pytest.mark.parametrize('schedule', CAMERAS)
def test_a_picture_is_ordered_before_it_is_shown_and_after_its_exposure(schedule):
    ordered: dict[int, int] = {}
    for now in range(STEP_MS, 3000, STEP_MS):
        for index in schedule.indices(now - STEP_MS, now, schedule.exposure):
            assert now >= schedule.time_ms(index) + schedule.exposure
            ordered[index] = now
        for index in schedule.indices(now - STEP_MS, now, schedule.latency):
            assert ordered[index] < now


STEPS = 90
LISTENERS = {
    'floor_localizer': ('/floor/image_raw',),
    'vlc_beacon': ('/ceiling/image_raw',),
    'stereo_landmark': ('/left/image_rect', '/right/image_rect'),
    'reward_planner': ('/depth/image',),
    'collision_monitor': ('/depth/image',),
    'motor_bridge': (),
    'pose_arbiter': (),
}

SIZES = {'floor': (235, 235), 'ceiling': (384, 480), 'stereo': (480, 752), 'depth': (120, 160)}


class StubNode(Node):
    """A mission node that stores its pictures' topics, stamps and clock times; bridge and arbiter also publish."""

    def __init__(self, name, **options):
        super().__init__(name, **options)
        self.received, self.clock_times = [], []
        for topic in LISTENERS[name]:
            self.create_subscription(Image, topic, partial(self.store, topic), 10)
        self.create_subscription(Clock, '/clock', self.on_clock, 10)
        self.odometry = self.create_publisher(Odometry, '/odom', 10)
        self.pose = self.create_publisher(PoseStamped, '/pose_arbiter/pose', 10)

    def store(self, topic, message):
        self.received.append((topic, mission_time(message.header.stamp), [0, *self.clock_times][-1]))

    def on_clock(self, message):
        self.clock_times.append(mission_time(message.clock))
        header = Header(stamp=message.clock, frame_id='map')
        if self.get_name() == 'motor_bridge':
            self.odometry.publish(Odometry(header=header))
        if self.get_name() == 'pose_arbiter':
            pose = PoseStamped(header=header)
            pose.pose.orientation.w = 1.0
            self.pose.publish(pose)


class BlackPictures:
    """Renders black images and stores the requests."""

    def __init__(self):
        self.requested: dict[tuple[str, int], object] = {}

    def request(self, sensor, index, time, path, _people):
        self.requested[sensor, index] = time, path

    def collect(self, sensor, index):
        assert (sensor, index) in self.requested
        kind = np.float32 if sensor == 'depth' else np.uint8
        return [np.zeros(SIZES[sensor], kind)] * (2 if sensor == 'stereo' else 1)


@pytest.fixture(scope='module')
def run():
    """Run some steps with stubs for all nodes."""
    with isolated_graph() as graph:
        nodes = {name: graph.add(partial(StubNode, name)) for name in LISTENERS}
        node = graph.node('scene_simulator')
        controller = EmulatedController(EmulatorSettings(), np.random.default_rng(0))
        sensors = MissionSensors(0, {name: steady_light() for name in LAMPS})
        worker, subscribers = BlackPictures(), MissionSubscribers(node)
        steps = Simulator(node, graph.executor, controller, Lock(), sensors, worker, subscribers)
        assert graph.spin_until(lambda: all(steps.publishers.subscriber_count(camera.name) for camera in CAMERAS))
        for _ in range(STEPS):
            steps.step()
        yield nodes, steps, controller, worker


def test_every_picture_arrives_in_its_order(run):
    nodes, steps, _, _ = run
    for camera, listener in zip(CAMERAS, ('floor_localizer', 'vlc_beacon', 'stereo_landmark', 'reward_planner')):
        due = [1e-3 * camera.time_ms(index) for index in camera.indices(0, steps.now, camera.latency)]
        assert due
        for topic in LISTENERS[listener]:
            stamps = [stamp for name, stamp, _ in nodes[listener].received if name == topic]
            assert stamps == pytest.approx(due)


def test_no_picture_comes_before_its_latency(run):
    nodes, _, _, _ = run
    latency = {
        'floor_localizer': 60,
        'vlc_beacon': 60,
        'stereo_landmark': 200,
        'reward_planner': 80,
        'collision_monitor': 80,
    }
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
