"""How many files of the product run on four ways through the suite: `./shirube bench files_on_paths`.

Messages of the committed bags are handed to the callbacks of the nodes. Counted are the Python files below `src` of
which a function runs: from an image to its pose, from a cloud to the map, for a late pose of which the arbiter
processes the later measurements again, and from the configuration of a lesson to the files of the place.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from itertools import islice
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import rclpy
from _figures import count
from _harness import Option, Run, run_benchmark
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2, PointField

from floor_localizer.node import FloorLocalizerNode
from pose_arbiter.node import PoseArbiterNode
from reward_planner.node import RewardPlannerNode
from shirube_bags.bag_reader import BagMessage, BagReader
from stereo_landmark.commands.teach import main as teach

ROOT = Path(__file__).resolve().parents[1]
BAGS = ROOT / 'bags'
FLOOR = {'image_transport': 'compressed', 'camera_xyz': [0.0, 0.0, 0.13]}


@contextmanager
def watched_files(found: set[str]) -> Iterator[None]:
    """Collect the product files of which a function starts."""

    def note(frame: FrameType, event: str, _: object) -> None:
        path = Path(frame.f_code.co_filename)
        if event == 'call' and path.is_relative_to(ROOT / 'src') and frame.f_code.co_name != '<module>':
            found.add(str(path.relative_to(ROOT / 'src')))

    sys.setprofile(note)
    try:
        yield
    finally:
        sys.setprofile(None)


class FedNode:
    """A node whose callbacks are called with the messages of a bag, without a network in between."""

    def __init__(self, context: Context, create: type[Node], **parameters: object) -> None:
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        options: dict[str, Any] = {'context': context, 'parameter_overrides': overrides}
        self.node = create(**options)
        self._subscriptions = {one.topic_name: one for one in self.node.subscriptions}

    def feed(self, topic: str, message: object) -> None:
        """Call the callback of a topic."""
        self._subscriptions[topic].callback(message)

    def feed_raw(self, raw: BagMessage) -> None:
        """Feed a message of a bag."""
        self.feed(raw.topic, deserialize_message(raw.raw, self._subscriptions[raw.topic].msg_type))

    def run_timers(self) -> None:
        """Call each timer once."""
        for timer in self.node.timers:
            timer.callback()


def read(bag: str, topics: Sequence[str], messages: int) -> list[BagMessage]:
    """Return the first messages of some topics of a bag."""
    with BagReader(BAGS / bag) as reader:
        return list(islice(reader.messages(topics), messages))


def image_to_pose(context: Context, found: set[str]) -> None:
    """Two images of the belly camera: the first is searched in the whole map, the second near the first pose."""
    floor = FedNode(context, FloorLocalizerNode, **FLOOR)
    for raw in read('floor_drive', ['/camera_info', '/odom'], 40):
        floor.feed_raw(raw)
    images = read('floor_drive', ['/image_raw/compressed'], 2)
    with watched_files(found):
        for raw in images:
            floor.feed_raw(raw)


def cloud_to_map(context: Context, found: set[str]) -> None:
    """A cloud between two poses, and the timers that map it and publish the maps."""
    planner = FedNode(context, RewardPlannerNode, use_sim_time=True)
    v, u = np.indices((120, 160))
    depth = np.where(u < 80, 1.0, 1.6)
    points = np.stack([(u - 80) / 120 * depth, (v - 60) / 120 * depth, depth], axis=2).astype(np.float32)
    fields = [PointField(name=n, offset=4 * i, datatype=7, count=1) for i, n in enumerate('xyz')]
    cloud = PointCloud2(height=120, width=160, fields=fields, point_step=12, row_step=1920, is_dense=True)
    cloud.data = points.tobytes()
    cloud.header.frame_id = 'camera_optical_frame'
    for tenths in range(1, 8):
        set_time(planner, tenths)
        pose = PoseStamped()
        pose.header.stamp = Time(nanosec=tenths * 100_000_000)
        planner.feed('/pose', pose)
        if tenths == 3:  # a second frame is mapped without the start of the map
            cloud.header.stamp = pose.header.stamp
            planner.feed('/points', cloud)
            planner.run_timers()
        if tenths == 6:
            cloud.header.stamp = pose.header.stamp
            with watched_files(found):
                planner.feed('/points', cloud)
                planner.run_timers()


def late_pose(context: Context, found: set[str]) -> None:
    """A pose that arrives after later ones, and the estimate with all of them."""
    arbiter = FedNode(context, PoseArbiterNode, use_sim_time=True)
    source = '/floor_localizer/pose_with_covariance'
    kept = read('mission', [source, '/odom'], 900)
    late = [raw for raw in kept if raw.topic == source][-10]
    for raw in kept:
        set_time(arbiter, raw.stamp_ns // 100_000_000)
        if raw is not late:
            arbiter.feed_raw(raw)
    arbiter.run_timers()
    with watched_files(found):
        arbiter.feed_raw(late)
        arbiter.node._arbiter.estimate_at(kept[-1].stamp_ns)  # noqa: SLF001 without its publishers


def set_time(node: FedNode, tenths: int) -> None:
    """Set the simulated time [0.1 s]."""
    node.feed('/clock', Clock(clock=Time(sec=tenths // 10, nanosec=tenths % 10 * 100_000_000)))


def lesson_to_place(_: Context, found: set[str]) -> None:
    """The lesson of the corridor."""
    with tempfile.TemporaryDirectory() as folder, watched_files(found), redirect_stdout(StringIO()):
        teach(['--batch', str(BAGS / 'corridor_teach/lesson.yaml'), '--places', folder])


WAYS = {
    'image → pose': image_to_pose,
    'cloud → map': cloud_to_map,
    'late pose': late_pose,
    'lesson → place': lesson_to_place,
}


def main(run: Run, listed: bool) -> None:
    """Count the files of each way."""
    context = Context()
    rclpy.init(context=context)
    table = run.table('Files of which a function runs', 'way', 'files')
    for name, walk in WAYS.items():
        found: set[str] = set()
        walk(context, found)
        table.add(name, count(len(found), better='lower'))
        if listed:
            run.note('\n    '.join([name, *sorted(found)]))


if __name__ == '__main__':
    run_benchmark(main, listed=Option(False, False, 'name the files'))
