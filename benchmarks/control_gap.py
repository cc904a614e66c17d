"""Largest gap between velocity commands of the live planner on a large map, with a goal far away.

The map is a square hall with walls across, whose doors are at alternate ends: the search visits most of its cells. The
robot drives towards the opposite corner; after some seconds an obstacle blocks its route.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import monotonic

import numpy as np
from _figures import count, measured
from _harness import Option, Run

RESOLUTION, START, OBSTACLE_TIME = 0.05, (1.0, 1.0), 10.0
PERIOD, START_SECONDS = 0.05, 180.0


def write_map(folder: Path, cells: int) -> Path:
    """Write the map of a hall of cells x cells with walls every 5 m."""
    from reward_planner.core.occupancy_map import GridFrame, OccupancyMap  # noqa: PLC0415
    from reward_planner.files.occupancy_map_file import save_occupancy_map  # noqa: PLC0415

    occupancy = np.zeros((cells, cells), dtype=np.int8)
    occupancy[[0, -1]] = occupancy[:, [0, -1]] = 100
    for number, column in enumerate(range(100, cells - 40, 100)):
        occupancy[slice(0, -40) if number % 2 else slice(40, None), column] = 100
    path = folder / 'hall.yaml'
    save_occupancy_map(path, OccupancyMap(GridFrame(0.0, 0.0, RESOLUTION, cells, cells), occupancy))
    return path


def drive(cells: int, seconds: float, thread: bool) -> tuple[list[float], float]:
    """Drive for some time; return the gaps between commands since the goal [s], and the distance driven [m]."""
    import rclpy  # noqa: PLC0415
    from _planner_robot import PlannerRobot  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as name:
        values = {
            'map_file': str(write_map(Path(name), cells)),
            'resolution': RESOLUTION,
            'drive': True,
            'planning_thread': thread,
        }
        arguments = [part for key, value in values.items() for part in ('-p', f'{key}:={value}')]
        command = [sys.executable, '-m', 'reward_planner.node', '--ros-args', *arguments]
        process = subprocess.Popen(command, env=os.environ, stderr=subprocess.DEVNULL)
        rclpy.init()
        try:
            robot = PlannerRobot(START)
            robot.wait_for_planner(process, START_SECONDS)
            goal = RESOLUTION * cells - 1.0
            robot.run(2.0, PERIOD)
            robot.send_goal(goal, goal)
            began = monotonic()
            robot.run(min(OBSTACLE_TIME, 0.5 * seconds), PERIOD)
            robot.add_obstacle(1.5)
            robot.run(began + seconds - monotonic(), PERIOD)
            ended = monotonic()
        finally:
            process.terminate()
            process.wait()
            rclpy.try_shutdown()
    times = [began, *(time for time in robot.command_times if time > began)]
    return list(np.diff([*times, ended])), math.dist(robot.position, START)


def main(run: Run, cells: int, seconds: float) -> None:
    """Drive with planning in the control loop and beside it."""
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    table = run.table('Gaps of cmd_vel', 'planning | largest gap s | gaps over 0.1 s | commands | way m')
    for thread in (False, True):
        gaps, way = drive(cells, seconds, thread)
        over = count(sum(gap > 0.1 for gap in gaps), better='lower')
        name = 'in threads' if thread else 'in the control loop'
        table.add(name, measured(max(gaps), '.3f'), over, len(gaps), f'{way:.1f}')


if __name__ == '__main__':
    from _harness import run_benchmark

    run_benchmark(
        main,
        cells=Option(2000, 400, 'of a side of the map'),
        seconds=Option(25.0, 6.0, 'of driving after the goal'),
    )
