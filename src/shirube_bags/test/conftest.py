"""Fixtures: bags, ROS nodes and processes."""

import os
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import rclpy
from domain_coordinator import domain_id
from node_testing import isolated_graph
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image

import shirube_bags
from shirube_bags.bag_reader import jazzy_types
from shirube_bags.bag_writer import BagWriter

TYPES = jazzy_types().types
START_NS = 1_700_000_000_123_456_789


class Messages:
    """Makes messages without ROS."""

    def header(self, stamp_ns):
        time = TYPES['builtin_interfaces/msg/Time'](*divmod(stamp_ns, 10**9))
        return TYPES['std_msgs/msg/Header'](time, 'map')

    def image(self, stamp_ns, side=16):
        pixels = np.random.default_rng(stamp_ns).integers(0, 256, side * side).astype(np.uint8)
        return TYPES['sensor_msgs/msg/Image'](self.header(stamp_ns), side, side, 'mono8', 0, side, pixels)

    def pose(self, stamp_ns, x, y, yaw):
        place = TYPES['geometry_msgs/msg/Point'](x, y, 0.0)
        turn = TYPES['geometry_msgs/msg/Quaternion'](0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2))
        pose = TYPES['geometry_msgs/msg/Pose'](place, turn)
        return TYPES['geometry_msgs/msg/PoseStamped'](self.header(stamp_ns), pose)

    def text(self, text):
        return TYPES['std_msgs/msg/String'](text)


@pytest.fixture
def messages():
    return Messages()


@pytest.fixture
def bag_path(tmp_path, messages) -> Path:
    """A bag of images at 50 Hz and poses between them; it lasts 0.8 s."""
    path = tmp_path / 'drive'
    with BagWriter(path) as bag:
        for index in range(41):
            stamp = START_NS + index * 20_000_000
            bag.write('/image_raw', 'sensor_msgs/msg/Image', messages.image(stamp), stamp)
            if index < 40:
                pose = messages.pose(stamp + 10_000_000, 0.01 * index, 0.0, 0.1)
                bag.write('/true_pose', 'geometry_msgs/msg/PoseStamped', pose, stamp + 10_000_000)
    return path


@pytest.fixture
def domain(monkeypatch, tmp_path):
    """An isolated ROS domain on this host."""
    with domain_id() as number:
        monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        monkeypatch.setenv('ROS_DOMAIN_ID', str(number))
        monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path / 'log'))
        # Children find the packages where this process found them.
        monkeypatch.setenv('PYTHONPATH', os.pathsep.join(import_paths()))
        yield number


def import_paths():
    own = str(Path(shirube_bags.__file__).parents[1])
    return [own, *filter(None, os.environ.get('PYTHONPATH', '').split(os.pathsep))]


@pytest.fixture
def start_command(domain, tmp_path):
    """Starts an executable of this package in a new process, which ends with the test."""
    processes = []

    def start(name, *arguments):
        command = [sys.executable, '-m', f'shirube_bags.commands.{name}', *map(str, arguments)]
        pipes = {'stdout': subprocess.PIPE, 'stderr': subprocess.PIPE, 'text': True}
        processes.append(subprocess.Popen(command, cwd=tmp_path, **pipes))
        return processes[-1]

    yield start
    for process in processes:
        if process.poll() is None:
            process.kill()
        process.communicate()


@pytest.fixture
def ros(domain):
    with isolated_graph(domain) as graph:
        yield graph


def nanoseconds(time_message):
    return time_message.sec * 10**9 + time_message.nanosec


@pytest.fixture
def stamp_of():
    """Returns the header stamp of a message [ns]."""
    return lambda message: nanoseconds(message.header.stamp)


class Listener:
    """Subscribes to the images of a bag and to /clock."""

    def __init__(self, ros, name, qos, work=0.0):
        node = ros.node(name, parameter_overrides=[rclpy.Parameter('use_sim_time', value=True)])
        node.create_subscription(Image, 'image_raw', self.note, qos)
        node.create_subscription(Clock, '/clock', self.note_tick, 100)
        self.node, self.work, self.executor = node, work, ros.executor
        self.images, self.clock, self.ticks = [], [], []

    def note(self, image):
        self.images.append(image)
        self.clock.append(self.node.get_clock().now().nanoseconds)
        time.sleep(self.work)

    def note_tick(self, tick):
        self.ticks.append(nanoseconds(tick.clock))

    def spin_while_running(self, process):
        while process.poll() is None:
            self.executor.spin_once(timeout_sec=0.05)
        end = time.monotonic() + 0.2
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)

    def stamps(self):
        return [nanoseconds(each.header.stamp) for each in self.images]


@pytest.fixture
def listen(ros):
    """Makes a listener with a name, a QoS and a time of work per image [s]."""
    return partial(Listener, ros)
