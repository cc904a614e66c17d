"""Largest gap between velocity commands of the live planner on a large map, with a goal far away.

The map is a square hall with walls across, whose doors are at alternate ends: the search visits most of its cells. The
robot drives towards the opposite corner.
"""

import math
import os
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic

import numpy as np
import rclpy
from _figures import count, measured
from _harness import Option, Run, run_benchmark
from _live_node import running_node
from geometry_msgs.msg import PoseStamped, TwistStamped
from node_testing import cloud_from_points
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header

from reward_planner.core.occupancy_map import GridFrame, OccupancyMap
from reward_planner.files.occupancy_map_file import save_occupancy_map
from shirube_core.geometry import SE2
from shirube_ros.message_conversion import pose_stamped

RESOLUTION, START, PERIOD = 0.05, SE2(1.0, 1.0, math.pi / 2.0), 0.05
GRID = np.meshgrid(np.linspace(0.5, 3.0, 80), np.linspace(-1.5, 1.5, 60), 0.0)
FLOOR = np.stack(GRID, axis=-1).reshape(-1, 3).astype(np.float32)


class Robot:
    """A simulated robot: publishes its pose and a cloud of the floor ahead, and follows cmd_vel."""

    def __init__(self) -> None:
        self.node, self.pose = rclpy.create_node('robot'), START
        self.commands: list[tuple[float, float, float]] = [(0.0, 0.0, 0.0)]  # time, speed, turn rate
        kinds = {'pose': PoseStamped, 'goal_pose': PoseStamped, 'points': PointCloud2}
        self.outputs = {topic: self.node.create_publisher(kind, topic, 10) for topic, kind in kinds.items()}
        self.node.create_subscription(TwistStamped, 'cmd_vel', self._take, 10)

    def _take(self, message: TwistStamped) -> None:
        self.commands.append((monotonic(), message.twist.linear.x, message.twist.angular.z))

    def send_pose(self, topic: str, pose: SE2) -> None:
        """Publish a pose in the map."""
        stamp = self.node.get_clock().now().to_msg()
        self.outputs[topic].publish(pose_stamped(pose, Header(stamp=stamp, frame_id='map')))

    def run(self, seconds: float) -> None:
        """Drive for some time: a pose in each period, a cloud in each second one."""
        begin = monotonic()
        for step in range(round(seconds / PERIOD)):
            _, speed, turn_rate = self.commands[-1]
            self.pose = self.pose @ SE2(PERIOD * speed, 0.0, PERIOD * turn_rate)
            self.send_pose('pose', self.pose)
            if step % 2 == 0:
                header = Header(stamp=self.node.get_clock().now().to_msg(), frame_id='base_link')
                self.outputs['points'].publish(cloud_from_points(FLOOR, header))
            while (left := begin + PERIOD * (step + 1) - monotonic()) > 0.0:
                rclpy.spin_once(self.node, timeout_sec=left)


def write_map(path: Path, cells: int) -> None:
    """Write the map of a hall of cells x cells with walls every 5 m."""
    occupancy = np.zeros((cells, cells), dtype=np.int8)
    occupancy[[0, -1]] = occupancy[:, [0, -1]] = 100
    for number, column in enumerate(range(100, cells - 40, 100)):
        occupancy[slice(0, -40) if number % 2 else slice(40, None), column] = 100
    save_occupancy_map(path, OccupancyMap(GridFrame(0.0, 0.0, RESOLUTION, cells, cells), occupancy))


def drive(path: Path, goal: float, seconds: float, thread: bool) -> tuple[list[float], float]:
    """Drive for some time; return the gaps between commands since the goal [s], and the distance driven [m]."""
    values = {'map_file': path, 'resolution': RESOLUTION, 'drive': True, 'planning_thread': thread}
    with running_node('reward_planner.node', values) as wait_until:
        robot = Robot()
        wait_until(robot.node, lambda: all(each.get_subscription_count() for each in robot.outputs.values()))
        robot.run(2.0)
        robot.send_pose('goal_pose', SE2(goal, goal, 0.0))
        began = monotonic()
        robot.run(seconds)
        times = [began, *(time for time, *_ in robot.commands if time > began), monotonic()]
        return list(np.diff(times)), robot.pose.distance_to(START)


def main(run: Run, cells: int, seconds: float) -> None:
    """Drive with planning in the control loop and beside it."""
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    table = run.table('Gaps of cmd_vel', 'planning | largest gap s | gaps over 0.1 s | commands | way m')
    with TemporaryDirectory() as folder:
        path = Path(folder) / 'hall.yaml'
        write_map(path, cells)
        for name, thread in (('in the control loop', False), ('in threads', True)):
            gaps, way = drive(path, RESOLUTION * cells - 1.0, seconds, thread)
            over = count(sum(gap > 0.1 for gap in gaps), better='lower')
            table.add(name, measured(max(gaps), '.3f'), over, len(gaps), f'{way:.1f}')


if __name__ == '__main__':
    run_benchmark(
        main, cells=Option(2000, 400, 'of a side of the map'), seconds=Option(20.0, 6.0, 'of driving after the goal')
    )
