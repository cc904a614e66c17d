"""Short runs of every node on the committed bags, as outside programs see them: topics in, topics out.

Nothing here names an internal of a node, so that a change of the code that keeps its behaviour keeps these results.
"""

import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid
from node_testing import isolated_graph
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from floor_localizer.node import FloorLocalizerNode
from pose_arbiter.node import PoseArbiterNode
from reward_planner.commands.plan import main as plan
from reward_planner.node import RewardPlannerNode
from shirube_bags.bag_reader import BagMessage, BagReader
from shirube_bags.lockstep import replay_in_lockstep
from shirube_ros.message_conversion import planar_pose
from shirube_ros.node import node_executor
from shirube_ros.quality_of_service import map_profile, pose_profile
from stereo_landmark.commands.teach import main as teach
from stereo_landmark.node import StereoLandmarkNode
from vlc_beacon.commands.renew_counters import main as renew_counters
from vlc_beacon.node import VlcBeaconNode

BAGS = Path(__file__).parents[1] / 'bags'
Result = dict[str, Any]
Parameters = dict[str, object]
CORRIDOR = {'camera_xyz': [0.1, 0.12, 1.25]}
REPEATS = {'left': 3.5, 'right': 5.0, 'light': 3.5, 'hidden': 3.5, 'moved': 3.5}
"""Corridor drives and how much of them is replayed [s]."""
BLOCK = 10
"""Cells along a side of the blocks in which a grid is counted."""


class Excerpt:
    """The first seconds of a bag; looks like a `BagReader`."""

    def __init__(self, bag: BagReader, seconds: float) -> None:
        self._bag, self.topics = bag, bag.topics
        self.select_topics = bag.select_topics
        self._end_ns = bag.start_ns + round(1e9 * seconds)

    def messages(self, topics: Iterable[str] = ()) -> Iterator[BagMessage]:
        yield from self._bag.messages_between(topics, 0, self._end_ns)


class Recorder:
    """Subscribes to what a node publishes and keeps it.

    Attributes:
        poses: stamp [ns], x [m], y [m] and yaw [rad] of each pose.
        levels: diagnostic levels from the first pose on in their order, repetitions left out.
        commands: JSON texts of `~/command`.
        grids: the last grid of each topic.
    """

    def __init__(self, node: Node, name: str) -> None:
        self.poses: list[tuple[int, float, float, float]] = []
        self.levels: list[int] = []
        self.commands: list[str] = []
        self.grids: dict[str, OccupancyGrid] = {}
        listen = node.create_subscription
        listen(PoseStamped, f'/{name}/pose', self._add_pose, pose_profile())
        listen(DiagnosticArray, '/diagnostics', self._add_levels, 10)
        listen(String, f'/{name}/command', lambda message: self.commands.append(message.data), 10)
        for grid in ('map', 'local_map'):
            topic = f'/{name}/{grid}'
            listen(OccupancyGrid, topic, lambda message, grid=grid: self.grids.update({grid: message}), map_profile())

    def _add_pose(self, message: PoseStamped) -> None:
        stamp, pose = message.header.stamp, planar_pose(message.pose, 'pose')
        self.poses.append((stamp.sec * 1_000_000_000 + stamp.nanosec, pose.x, pose.y, pose.yaw))

    def _add_levels(self, message: DiagnosticArray) -> None:
        # Whether a report comes before the first message is a race.
        for status in message.status if self.poses or self.grids else ():
            level = status.level[0]
            if self.levels[-1:] != [level]:
                self.levels.append(level)

    def result(self, samples: int = 60) -> Result:
        """Return what was published, of the poses an even sample."""
        step = max(1, len(self.poses) // samples)
        found: Result = {'pose_count': len(self.poses), 'levels': self.levels}
        found['poses'] = [[s, *(round(v, 7) for v in pose)] for s, *pose in self.poses[::step]]
        if self.commands:
            found['commands'] = self.commands
        if self.grids:
            found['grids'] = {name: count_cells(grid) for name, grid in sorted(self.grids.items())}
        return found


def count_cells(grid: OccupancyGrid) -> Result:
    """Return a grid's place and how many cells of it are occupied and free, block by block."""
    info = grid.info
    cells = np.array(grid.data, np.int16).reshape(info.height, info.width)
    padded = np.pad(cells, [(0, -side % BLOCK) for side in cells.shape], constant_values=-1)
    blocks = padded.reshape(padded.shape[0] // BLOCK, BLOCK, padded.shape[1] // BLOCK, BLOCK)
    return {
        'origin': [round(info.origin.position.x, 6), round(info.origin.position.y, 6)],
        'size': [info.width, info.height],
        'occupied': (blocks >= 65).sum(axis=(1, 3)).ravel().tolist(),
        'free': ((blocks >= 0) & (blocks < 65)).sum(axis=(1, 3)).ravel().tolist(),
    }


def replay(
    create: Callable[..., Node], name: str, parameters: Parameters, drives: Sequence[tuple[str, Sequence[str], float]]
) -> Result:
    """Return what a node publishes on the first seconds of bags, each replayed in lock step to a new node.

    Args:
        create: class of the node.
        name: name of the node.
        parameters: its parameters; simulated time is set here.
        drives: name of the bag, its topics, and how much of it is replayed [s].
    """
    results = {}
    for bag_name, topics, seconds in drives:
        with isolated_graph() as graph, BagReader(BAGS / bag_name) as bag:
            node = graph.add(create, use_sim_time=True, **parameters)
            player = graph.add(lambda **options: Node('player', **options))
            recorder = Recorder(player, name)
            executor = node_executor(graph.context)
            for each in (node, player):
                executor.add_node(each)
            replay_in_lockstep(Excerpt(bag, seconds), player, executor, topics)
            for _ in range(10):  # what was published last is still on its way
                executor.spin_once(timeout_sec=0.05)
            executor.shutdown()
        results[bag_name] = recorder.result()
    return results


def run_floor(folder: Path) -> Result:
    topics = ('/image_raw/compressed', '/camera_info', '/odom')
    return replay(
        FloorLocalizerNode,
        'floor_localizer',
        {'image_transport': 'compressed', 'camera_xyz': [0.0, 0.0, 0.13]},
        [('floor_drive', topics, 25.0)],
    )


def run_lamps(folder: Path) -> Result:
    topics = ('/image_raw/compressed', '/camera_info', '/imu', '/odom')
    shutil.copy(BAGS / 'lamp_drive/demo_key', folder / 'key')
    (folder / 'key').chmod(0o600)
    assert renew_counters([str(folder / 'counters.json'), '--floor', '0']) == 0
    common = {'image_transport': 'compressed', 'camera_xyz': [0.0, 0.0, 0.0]}
    return replay(
        VlcBeaconNode,
        'vlc_beacon',
        {
            **common,
            'beacons_file': str(BAGS / 'lamp_drive/beacons.yaml'),
            'key_file': str(folder / 'key'),
            'counter_file': str(folder / 'counters.json'),
        },
        [('lamp_drive', topics, 9.0)],
    ) | replay(
        VlcBeaconNode,
        'vlc_beacon',
        {
            **common,
            'beacons_file': str(BAGS / 'lamp_drive_rolling/beacons.yaml'),
            'shutter': 'rolling',
            'exposure_time': 60e-6,
        },
        [('lamp_drive_rolling', topics, 4.0)],
    )


def run_stereo(folder: Path) -> Result:
    assert teach(['--batch', str(BAGS / 'corridor_teach/lesson.yaml'), '--places', str(folder)]) == 0
    topics = ('left/image_rect', 'left/camera_info', 'right/image_rect', 'right/camera_info')
    topics = [f'/{topic}/compressed' if 'image' in topic else f'/{topic}' for topic in topics]
    return replay(
        StereoLandmarkNode,
        'stereo_landmark',
        {'image_transport': 'compressed', 'places_dir': str(folder), **CORRIDOR},
        [(f'corridor_{name}', [*topics, '/imu'], seconds) for name, seconds in REPEATS.items()],
    )


def run_planner_map(folder: Path) -> Result:
    images = [
        f'/{name}/{topic}' for name in ('left', 'right', 'top') for topic in ('image_rect/compressed', 'camera_info')
    ]
    return replay(
        RewardPlannerNode,
        'reward_planner',
        {'source': 'trinocular', 'image_transport': 'compressed', 'camera_xyz': [0.1, 0.05, 0.4]},
        [('room_drive', ['/pose', *images], 12.0)],
    )


def run_planner_routes(folder: Path) -> Result:
    write_floor_plan(folder / 'plan')
    routes = {}
    for mode in ('optimal', 'reward'):
        csv = folder / f'{mode}.csv'
        arguments = ['--start', '0.5', '0.5', '--goal', '5.5', '3.5', '--mode', mode, '--csv', str(csv)]
        assert plan([str(folder / 'plan.yaml'), *arguments]) == 0
        points = np.loadtxt(csv, delimiter=',', skiprows=1, usecols=(0, 1))
        routes[mode] = {
            'length': round(float(np.hypot(*np.diff(points, axis=0).T).sum()), 4),
            'ends': points[[0, -1]].round(4).tolist(),
        }
    return routes


def write_floor_plan(path: Path) -> None:
    """Write a map of two rooms and a door, as map_server writes it."""
    cells = np.full((80, 120), 254, np.uint8)
    cells[[0, -1]] = cells[:, [0, -1]] = 0
    cells[:, 60] = 0
    cells[30:46, 60] = 254
    cells[10:60, 90] = 0
    path.with_suffix('.pgm').write_bytes(b'P5\n120 80\n255\n' + cells.tobytes())
    path.with_suffix('.yaml').write_text(
        f'image: {path.name}.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n'
        'occupied_thresh: 0.65\nfree_thresh: 0.196\n'
    )


def run_arbiter(folder: Path) -> Result:
    sources = ('floor_localizer', 'stereo_landmark', 'vlc_beacon')
    topics = [f'/{name}/pose_with_covariance' for name in sources]
    return replay(PoseArbiterNode, 'pose_arbiter', {}, [('mission', [*topics, '/odom'], 30.0)])


def run_bridge(folder: Path) -> Result:
    """Drive an emulated robot in simulated time: ahead, round a bend, and no command for the last seconds."""
    from emulated_robot import Robot  # noqa: PLC0415 lies beside the tests of motor_bridge

    with isolated_graph() as graph, Robot(graph, folder / 'tty', real_time=False, use_sim_time=True) as robot:
        clock = robot.person.create_publisher(Clock, '/clock', 10)
        robot.until(lambda: clock.get_subscription_count() >= 1)
        robot.until(lambda: robot.report.is_connected)
        steps = 180
        for step in range(1, steps + 1):
            with robot.lock:
                robot.controller.advance(step / 30.0)
            sec, nanosec = divmod(round(1e9 * step / 30.0), 10**9)
            seen = len(robot.odometry)
            if step <= 90:
                stamp = Time(sec=sec, nanosec=nanosec)
                robot.send(0.25, 0.0 if step <= 45 else 0.5, stamp)
            clock.publish(Clock(clock=Time(sec=sec, nanosec=nanosec)))
            robot.until(lambda seen=seen, step=step: len(robot.odometry) > seen or step == 1, 2.0)
        last = planar_pose(robot.odometry[-1].pose.pose, 'odom')
        speeds = [message.twist.twist.linear.x for message in robot.odometry]
        with robot.lock:
            true, is_stopped = robot.controller.T_world_base, robot.controller.is_stopped
        return {
            'end': [round(last.x, 4), round(last.y, 4), round(last.yaw, 4)],
            'odometry_error': round(last.distance_to(true), 4),
            'fastest': round(max(speeds), 3),
            'stops': is_stopped,
        }


RUNS: dict[str, Callable[[Path], Result]] = {
    'floor_localizer': run_floor,
    'vlc_beacon': run_lamps,
    'stereo_landmark': run_stereo,
    'reward_planner_map': run_planner_map,
    'reward_planner_routes': run_planner_routes,
    'pose_arbiter': run_arbiter,
    'motor_bridge': run_bridge,
}
