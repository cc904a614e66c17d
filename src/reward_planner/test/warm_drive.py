"""Compiles the kernels, drives, and prints kernels that were compiled only while driving; for a fresh process.

A frame of a room, a goal, an obstacle in the way that appears and disappears: the robot maps, plans, replans and
drives. Then three pictures become depth. Each mode of the planner has a process of its own, forked after the imports.
"""

import sys
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from l_rig import BASELINE, CAMERA, picture, projection
from numba.core.dispatcher import Dispatcher

sys.path.append(str(Path(__file__).parents[3] / 'tests'))

from test_navigator import MOUNT, ROOMS, SETTINGS, RoomDrive

from reward_planner.core.compile_kernels import compile_kernels
from reward_planner.core.depth.trinocular_depth import TrinocularRig, points_from_depth_image
from reward_planner.core.settings import DepthSettings, PlannerSettings
from scene_simulator.room.box_room import BoxRoom
from shirube_core.geometry import SE2


def signatures():
    """Number of compiled signatures of each kernel of the package."""
    return {
        f'{name}.{key}': len(value.signatures)
        for name, module in list(sys.modules.items())
        if name.startswith('reward_planner')
        for key, value in vars(module).items()
        if isinstance(value, Dispatcher)
    }


def drive(settings):
    """Drive towards a goal; a box comes into the way and leaves it."""
    robot = RoomDrive((), settings)
    robot.navigator.set_goal(SE2(5.0, 0.0, 0.0))
    for boxes in ((), ROOMS['box'], ()):
        robot.room = BoxRoom(robot.room.size, boxes)
        for _ in range(15):
            robot.tick()


def see():
    """Compute the depth of three pictures, and its points."""
    places = ((0.0, 0.0), (BASELINE, 0.0), (0.0, -BASELINE))
    rig = TrinocularRig(np.array([projection(CAMERA, *place) for place in places]), DepthSettings())
    depth = rig.compute(*(picture(*place) for place in places)).depth
    points_from_depth_image(depth, CAMERA)


def check(mode):
    """Print the kernels that gained a signature."""
    settings = replace(SETTINGS, planner=PlannerSettings(mode))
    compile_kernels(MOUNT, settings)
    before = signatures()
    drive(settings)
    see()
    for name, count in signatures().items():
        if count > before.get(name, 0):
            print(f'{mode}:{name}', flush=True)  # noqa: T201


processes = [get_context('fork').Process(target=check, args=(mode,)) for mode in ('optimal', 'reward')]
for process in processes:
    process.start()
    process.join()
sys.exit(max(process.exitcode for process in processes))
