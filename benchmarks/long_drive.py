"""Memory of the map over 1 km of driving, in one hall and over new ground: `./shirube bench long_drive`.

The robot drives lanes through a hall of 50 x 50 m with boxes, again and again, and then along a corridor without end.
It maps a frame every half metre, of a depth camera of 320 x 240 pixels, with the default settings.
"""

from __future__ import annotations

import argparse
import math
import os
import resource
from collections.abc import Iterator
from typing import NamedTuple

os.environ['OPENBLAS_NUM_THREADS'] = '1'

import numpy as np
from tqdm import tqdm

from reward_planner.core.mapping.mapping_settings import MappingSettings
from reward_planner.core.mapping.obstacle_mapper import ObstacleMapper
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from scene_simulator.room.box_room import Box, BoxRoom, forward_camera, points_from_depth
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

CAMERA = PinholeCamera(320, 240, 262.5, 262.5, 159.5, 119.5)
HEIGHT = 0.5
MOUNT = CameraMount((0.0, 0.0, HEIGHT), (-math.pi / 2.0, 0.0, -math.pi / 2.0))
STEP = 0.5
SPEED = 0.5
HALL = 50.0
LANES = 8
NEAR = 8.0
"""Boxes farther from the robot are not rendered [m]."""


class Place(NamedTuple):
    """A pose and the room around it."""

    pose: SE2
    room: BoxRoom


def hall_lanes(length: float) -> Iterator[Place]:
    """Yield places along lanes up and down the hall, over and over, for a length [m]."""
    rng = np.random.default_rng(3)
    boxes = []
    for x, y in rng.uniform(1.0, HALL - 1.0, (120, 2)):
        side, height = rng.uniform(0.2, 0.8, 2)
        boxes.append((x, y, 0.0, x + side, y + side, 0.3 + height))
    spacing = HALL / LANES
    lap = LANES * (HALL - 4.0)
    for way in np.arange(0.0, length, STEP):
        lane, along = divmod(
            way % (2.0 * lap) if way % (2.0 * lap) < lap else 2.0 * lap - way % (2.0 * lap), HALL - 4.0
        )
        up = (lane % 2 == 0) == (way % (2.0 * lap) < lap)
        y = 2.0 + (along if lane % 2 == 0 else HALL - 4.0 - along)
        pose = SE2((min(lane, LANES - 1) + 0.5) * spacing, y, math.pi / 2.0 if up else -math.pi / 2.0)
        yield Place(pose, BoxRoom((0.0, 0.0, 0.0, HALL, HALL, 4.0), near(boxes, pose)))


def corridor_places(length: float) -> Iterator[Place]:
    """Yield places along a corridor that runs askew to the map's axes, for a length [m]."""
    rng = np.random.default_rng(4)
    for way in np.arange(0.0, length, STEP):
        x, y = 0.8 * way, 0.6 * way
        pose = SE2(x, y, math.atan2(0.6, 0.8))
        side = rng.uniform(0.2, 0.8, 2)
        box = (x + 2.0, y + 2.5, 0.0, x + 2.0 + side[0], y + 2.5 + side[1], 0.9)
        yield Place(pose, BoxRoom((x - NEAR, y - NEAR, 0.0, x + NEAR, y + NEAR, 4.0), (box,)))


def near(boxes: list[Box], pose: SE2) -> tuple[Box, ...]:
    """Return the boxes around a pose."""
    return tuple(box for box in boxes if math.hypot(box[0] - pose.x, box[1] - pose.y) < NEAR)


def print_drive(places: Iterator[Place], length: float, report_every: float) -> None:
    """Map along the places and print what the memory is."""
    mapper = ObstacleMapper(MOUNT, VoxelSettings(), MappingSettings())
    print('| driven m | tiles kept | tiles MB | map MB | process MB (highest) |\n|---|---|---|---|---|')
    for k, place in enumerate(tqdm(places, total=int(length / STEP), leave=False)):
        T = forward_camera(place.pose.x, place.pose.y, HEIGHT, place.pose.yaw)
        points = points_from_depth(place.room.depth_image(CAMERA, T), CAMERA)
        mapper.add(k * STEP / SPEED, points, place.pose, CAMERA.fx)
        driven = (k + 1) * STEP
        if driven % report_every == 0.0:
            tiles, peak = mapper.voxels.tiles, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
            tqdm.write(
                f'| {driven:.0f} | {len(tiles)} | {tiles.bytes / 1e6:.1f} | '
                f'{mapper.map.bytes / 1e6:.2f} | {peak:.0f} |'
            )


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--metres', type=float, default=1000.0, help='length of each drive')
    metres = parser.parse_args().metres
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    print('## Memory over long drives\n\n`./shirube bench long_drive`')
    print(f'\n### In a hall of {HALL:.0f} x {HALL:.0f} m\n')
    print_drive(hall_lanes(metres), metres, metres / 10.0)
    print('\n### Over new ground, askew to the axes\n')
    print_drive(corridor_places(metres), metres, metres / 10.0)
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
