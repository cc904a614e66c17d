"""The experiment of Matsuda & Ukida in a rendered room: section 2 step by step, with figures 4 and 6 to 8.

In each cell the robot looks around with three cameras in an L (step 1): depth of both pairs, voxels by `count`, local
and global map. Then it moves to one of the eight cells around it by the rewards of Table 1 (step 2), until it is at the
goal (step 3). A false cell is occupied, but nothing solid is there or in the cells around it.
"""

import math
from pathlib import Path

import cv2
import numpy as np
from _figures import count, rate
from _harness import Option, Run, run_benchmark, use_one_core
from numpy.typing import NDArray

from reward_planner.commands.plan import save_picture
from reward_planner.core.depth.stereo_pair import pair_from_projections
from reward_planner.core.depth.trinocular_depth import TrinocularDepth, points_from_depth_image
from reward_planner.core.mapping.obstacle_mapper import ObstacleMapper
from reward_planner.core.occupancy_map import FREE, OCCUPIED, GridFrame, clearance
from reward_planner.core.reward.reward_walk import RewardWalk
from reward_planner.core.settings import DepthSettings, MappingSettings, RewardSettings, VoxelSettings
from scene_simulator.room.box_room import BoxRoom
from scene_simulator.room.room_drive import CameraRig, render_picture
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

ROOM = BoxRoom(
    (-1.0, -2.0, 0.0, 5.0, 2.0, 2.4),
    ((1.3, -0.8, 0.0, 1.7, 0.5, 0.8), (2.8, 0.1, 0.0, 3.2, 2.0, 1.0), (2.6, -2.0, 0.0, 3.0, -1.2, 0.6)),
)
RIG = CameraRig(
    PinholeCamera(160, 120, 120.0, 120.0, 79.5, 59.5),
    CameraMount((0.0, 0.0, 0.5), (-math.pi / 2.0, 0.0, -math.pi / 2.0)),
    0.1,
)
FRAME = GridFrame(-1.2, -2.2, 0.1, 64, 44)
START, GOAL = (0.05, 0.05), (4.25, 0.25)
VOXELS = VoxelSettings(rule='count', resolution=FRAME.resolution, range_max=3.5)
ROBOT_RADIUS = 0.2
HEADINGS = 8
STEPS_MAX = 300
NEAR_START = 1.0
PANEL = 360
Image = NDArray[np.uint8]


class PaperRobot:
    """The robot with its cameras and map; the noise of the images has a seed."""

    def __init__(self, seed: int) -> None:
        left, right, top = (RIG.projections[name] for name in ('left', 'right', 'top'))
        pairs = pair_from_projections(left, right), pair_from_projections(left, top)
        self.depth = TrinocularDepth(*pairs, DepthSettings(disparities=32, fusion='union'))
        self.mapper = ObstacleMapper(RIG.mount, VOXELS, MappingSettings())
        self.rng, self.stamp = np.random.default_rng(seed), 0.0

    def look_around(self, x: float, y: float) -> tuple[Image, NDArray[np.int8]]:
        """Map the surroundings (2.2); return the last input image and local map."""
        for heading in range(HEADINGS, 0, -1):
            pose = SE2(x, y, math.remainder(math.tau * (heading - 1) / HEADINGS, math.tau))
            images = [render_picture(ROOM, RIG.camera, T, 1.0, self.rng) for T in RIG.views(pose).values()]
            points = points_from_depth_image(self.depth.compute(*images).depth, RIG.camera)
            local, _ = self.mapper.add(self.stamp, points, pose, RIG.camera.fx)
            self.stamp += 0.1
        return images[0], local.occupancy


def occupancy_picture(occupancy: NDArray[np.int8], way: NDArray[np.int64] | None = None) -> Image:
    """Return a map with the areas of start and goal and the way, rows and columns of shape (n, 2); north is up."""
    picture = np.full((*occupancy.shape, 3), 200, dtype=np.uint8)
    picture[occupancy == FREE], picture[occupancy == OCCUPIED] = 255, 0
    scale = PANEL // occupancy.shape[0]
    large = picture.repeat(scale, axis=0).repeat(scale, axis=1)
    for place, colour in ((START, (0, 150, 0)), (GOAL, (0, 0, 220))):
        row, column = scale * FRAME.cell_of(place)
        cv2.rectangle(large, (column - scale, row - scale), (column + 2 * scale, row + 2 * scale), colour, -1)
    if way is not None:
        pixels = (scale * (way[:, ::-1] + 0.5)).astype(np.int32)
        cv2.polylines(large, [pixels], isClosed=False, color=(200, 60, 0), thickness=2)
    return large[::-1]


def montage(panels: dict[str, Image]) -> Image:
    """Return pictures of one height beside each other, with their names below."""
    parts = []
    for name, picture in panels.items():
        width = round(picture.shape[1] * PANEL / picture.shape[0])
        part = cv2.resize(picture, (width, PANEL), interpolation=cv2.INTER_NEAREST)
        part = cv2.copyMakeBorder(part, 8, 30, 8, 8, cv2.BORDER_CONSTANT, value=(255, 255, 255))
        place = (8, PANEL + 28)
        cv2.putText(part, name, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 0), 1, cv2.LINE_AA)
        parts.append(part)
    return np.asarray(cv2.hconcat(parts), dtype=np.uint8)


def local_picture(occupancy: NDArray[np.int8]) -> Image:
    """Return a local map as the paper draws it, obstacles white; north is up."""
    white = np.where(occupancy == OCCUPIED, 255, 0).astype(np.uint8)[::-1]
    return np.asarray(cv2.cvtColor(white, cv2.COLOR_GRAY2BGR), dtype=np.uint8)


def main(run: Run, png: str) -> None:
    """Drive once and draw the figures."""
    use_one_core()
    # Step 0: the robot knows where it is and where the goal is.
    start, goal = ((int(row), int(column)) for row, column in FRAME.cell_of([START, GOAL]))
    robot, walk = PaperRobot(run.seed), RewardWalk(FRAME.shape, start, goal, RewardSettings(visits='once'))
    maps, cells, seen = [robot.mapper.map.occupancy_in(FRAME)], [walk.cell], []
    while not walk.is_at_goal and len(cells) <= STEPS_MAX:
        # Step 1: look around. Step 2: move by the rewards. Step 3: again, until the goal.
        seen.append(robot.look_around(*FRAME.centre_of(walk.cell)))
        maps.append(robot.mapper.map.occupancy_in(FRAME))
        if not walk.advance(clearance(maps[-1] == OCCUPIED, FRAME.resolution) <= ROBOT_RADIUS + 1e-5):
            break
        cells.append(walk.cell)
    heights = VOXELS.height_min, VOXELS.height_max
    solid = ROOM.solid_cells((FRAME.origin_x, FRAME.origin_y), FRAME.resolution, FRAME.shape, heights)
    solids, places = FRAME.centre_of(np.argwhere(solid)), FRAME.centre_of(cells)
    gap = np.linalg.norm(places[:, None] - solids, axis=2).min() - ROBOT_RADIUS
    occupied, free = maps[-1] == OCCUPIED, maps[-1] == FREE
    false = occupied & (cv2.dilate(solid.astype(np.uint8), np.ones((3, 3), np.uint8)) == 0)
    near = np.hypot(*(FRAME.centre_of(np.argwhere(false)) - START).T) < NEAR_START
    heads = 'goal | steps | least clearance mm | occupied cells false | of these within 1 m of the start'
    run.table('Drive by the paper', heads, 'free cells solid').add(
        'reached' if walk.is_at_goal else 'not reached',
        count(len(cells) - 1, better='lower'),
        count(1e3 * gap, '.0f', better='higher'),
        rate(int(false.sum()), int(occupied.sum()), 'lower'),
        count(int(near.sum()), better='lower'),
        rate(int((free & solid).sum()), int(free.sum()), 'lower'),
    )
    if png:
        panels = {
            'Fig. 4 (a): situation': occupancy_picture(np.where(solid, OCCUPIED, FREE).astype(np.int8)),
            'Fig. 4 (b): initial map': occupancy_picture(maps[0]),
            'Fig. 6: input image': cv2.cvtColor(seen[0][0], cv2.COLOR_GRAY2BGR),
            'Fig. 7: local map': local_picture(seen[0][1]),
            'Fig. 8: final map': occupancy_picture(maps[-1], np.array(cells)),
        }
        save_picture(Path(png), montage(panels))


if __name__ == '__main__':
    run_benchmark(main, png=Option('', '', 'draws figures 4, 6, 7 and 8'))
