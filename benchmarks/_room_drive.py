"""The recorded drive through a room: its bag, its replay through the mapper, and the map against the truth."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from _harness import cpu_time
from numpy.typing import NDArray

from reward_planner.core.depth.trinocular_depth import points_from_depth_image
from reward_planner.core.navigator import Navigator, NavigatorSettings, SensorFrame
from reward_planner.core.occupancy_map import FREE, GridFrame, OccupancyMap, clearance
from reward_planner.core.settings import DrivingSettings, PlannerSettings, VoxelSettings
from scene_simulator.commands.room import HEIGHTS
from scene_simulator.room.box_room import points_from_depth
from scene_simulator.room.room_drive import RoomDrive
from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import SE2
from shirube_ros.camera.image import array_from_compressed_image
from shirube_ros.message_conversion import planar_pose

Image = NDArray[np.uint8]
BAG = Path(__file__).parents[1] / 'bags' / 'room_drive'
CAMERAS = ('left', 'right', 'top')
SEEN_FRAMES = 3  # A cell counts as seen where so many instants show a surface in it


class Instant(NamedTuple):
    """What the bag holds for one instant: stamp [s], images of the left, right and top camera, true ``T_map_base``."""

    stamp: float
    images: tuple[Image, Image, Image]
    truth: SE2


@dataclass
class RoomBag:
    """The bag's contents.

    Attributes:
        instants: instants in order of time.
        poses: poses of the localizer, with their stamps [s].
        projections: P of the cameras, shape (3, 4), by name.
        truth: the true map.
    """

    instants: list[Instant] = field(default_factory=list)
    poses: list[tuple[float, SE2]] = field(default_factory=list)
    projections: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    truth: OccupancyMap = field(init=False)


def load_room_bag() -> RoomBag:
    """Read the bag of `scene_simulator record_room_bag`; the true pose comes last at each instant."""
    bag, images = RoomBag(), dict[str, Image]()
    with BagReader(BAG) as reader:
        for raw in reader.messages():
            message, stamp = reader.decode(raw), 1e-9 * raw.stamp_ns
            name = raw.topic.split('/')[1]
            if raw.topic.endswith('/image_rect/compressed'):
                images[name] = array_from_compressed_image(message, raw.topic)
            elif raw.topic.endswith('/camera_info'):
                bag.projections[name] = message.p.reshape(3, 4)
            elif raw.topic == '/pose':
                bag.poses.append((stamp, planar_pose(message.pose, raw.topic)))
            elif raw.topic == '/truth/map':
                bag.truth = occupancy_of(message)
            elif raw.topic == '/ground_truth':
                left, right, top = (images[name] for name in CAMERAS)
                bag.instants.append(Instant(stamp, (left, right, top), planar_pose(message.pose, raw.topic)))
    return bag


def occupancy_of(message: object) -> OccupancyMap:
    """Return the map of a decoded OccupancyGrid."""
    info = message.info  # type: ignore[attr-defined]
    corner = info.origin.position
    frame = GridFrame(corner.x, corner.y, round(info.resolution, 6), info.width, info.height)
    return OccupancyMap(frame, message.data.reshape(info.height, info.width))  # type: ignore[attr-defined]


DepthOf = Callable[[Instant], NDArray[np.float32]]
"""Gives the depth of an instant, shape (height, width) [m], NaN for none."""


class Replay(NamedTuple):
    """What came of a replay: occupancy on the cells of the true map, CPU times by stage, number of mapped frames."""

    occupancy: NDArray[np.int8]
    milliseconds: dict[str, list[float]]
    frames: int


def replay(
    bag: RoomBag, truth: OccupancyMap, scene: RoomDrive, depth_of: DepthOf, rule: VoxelSettings | None = None
) -> Replay:
    """Send the bag through depth, mapper and global map, as the node does."""
    navigator = Navigator(scene.rig.mount, NavigatorSettings(rule or VoxelSettings()))
    times: dict[str, list[float]] = {'depth': [], 'mapping': []}
    frames = 0
    poses = iter([*bag.poses, (np.inf, SE2(0.0, 0.0, 0.0))])
    pose = next(poses)
    for instant in bag.instants:
        depth, taken = cpu_time(depth_of, instant)
        times['depth'].append(taken)
        while pose[0] <= instant.stamp:
            navigator.add_pose(*pose)
            pose = next(poses)

        def add(stamp: float, depth: NDArray[np.float32]) -> int:
            points = points_from_depth_image(depth, scene.rig.camera)
            navigator.add_frame(stamp, stamp, SensorFrame(points, scene.rig.camera.fx))
            return len(navigator.process_frames(stamp))

        mapped, taken = cpu_time(add, instant.stamp, depth)
        times['mapping'].append(taken)
        frames += mapped
    return Replay(navigator.mapper.map.occupancy_in(truth.frame), times, frames)


def seen_cells(bag: RoomBag, truth: OccupancyMap, scene: RoomDrive) -> NDArray[np.bool_]:
    """Return the solid cells of which the left camera saw a surface, from the true room and poses."""
    (low, high), reach = HEIGHTS, VoxelSettings().range_max
    counts = np.zeros(truth.frame.shape, dtype=np.int64)
    room = scene.room.boxes
    for instant in bag.instants:
        T = scene.rig.views(instant.truth)['left']
        points = points_from_depth(room.depth_image(scene.rig.camera, T), scene.rig.camera)
        near = points[np.hypot(np.hypot(points[:, 0], points[:, 1]), points[:, 2]) < reach]
        places = near @ T[:3, :3].T + T[:3, 3]
        places = places[(places[:, 2] > low) & (places[:, 2] < high)]
        cells = truth.frame.cell_of(places[:, :2])
        is_seen = np.zeros(truth.frame.shape, dtype=bool)
        is_seen[tuple(cells[truth.frame.contains(cells)].T)] = True
        counts += is_seen
    return np.asarray((counts >= SEEN_FRAMES) & truth.occupied())


@dataclass(frozen=True)
class Score:
    """A map against the truth.

    Attributes:
        precision: share of the occupied cells that have a solid one no farther than 0, 1 and 2 cells.
        recall: share of the seen solid cells that have an occupied one no farther than that.
        false_free: cells said to be free that are solid, and of these those deeper inside than one cell.
        free: number of cells said to be free.
        overlap: how deep the robot would be in something, at worst, where the map says that all ground under it is free
            and the planner's margin is kept [m].
        unseen_overlap: the same where only its middle need be free and the rest may be unknown, as for the planner [m].
    """

    precision: tuple[float, ...]
    recall: tuple[float, ...]
    false_free: tuple[int, int]
    free: int
    overlap: float
    unseen_overlap: float


def score(occupancy: NDArray[np.int8], truth: OccupancyMap, seen: NDArray[np.bool_], scene: RoomDrive) -> Score:
    """Compare the occupancy on the cells of the true map with it."""
    known, occupied_cells = OccupancyMap(truth.frame, occupancy).occupied(), truth.occupied()
    free = occupancy == FREE
    radius = PlannerSettings().robot_radius
    keep_away = radius + DrivingSettings().clearance_margin
    resolution = truth.frame.resolution
    is_passable = free & (clearance(known, resolution) > keep_away)
    is_known = clearance(~free, resolution)[is_passable] > radius
    gaps = distances_to_solid(truth.frame.centre_of(np.argwhere(is_passable)), scene)
    deep = occupied_cells & ~dilate_cells(~occupied_cells, 1)
    return Score(
        tuple(fraction_within(known, occupied_cells, reach) for reach in range(3)),
        tuple(fraction_within(seen, known, reach) for reach in range(3)),
        (int((free & occupied_cells).sum()), int((free & deep).sum())),
        int(free.sum()),
        radius - float(gaps[is_known].min(initial=radius)),
        radius - float(gaps.min(initial=radius)),
    )


def distances_to_solid(points_map: NDArray[np.float64], scene: RoomDrive) -> NDArray[np.float64]:
    """Return how far points, shape (n, 2), are from walls and from what is at the robot's heights, shape (n,) [m]."""
    low, high = HEIGHTS
    (x0, y0, _, x1, y1, _), points = scene.size, points_map
    distances = np.minimum(points - (x0, y0), (x1, y1) - points).min(axis=1)
    for box in scene.room.boxes.boxes:
        if box[2] < high and box[5] > low:
            nearest = np.clip(points, box[:2], box[3:5])
            distances = np.minimum(distances, np.hypot(*(nearest - points).T))
    return np.asarray(distances)


def fraction_within(cells: NDArray[np.bool_], others: NDArray[np.bool_], reach: int) -> float:
    """Return the share of cells that have one of the others within a square of this reach [cells]."""
    return float((cells & dilate_cells(others, reach)).sum() / max(cells.sum(), 1))


def dilate_cells(cells: NDArray[np.bool_], reach: int) -> NDArray[np.bool_]:
    """Return the cells and all around them within a square of this reach [cells]."""
    square = np.ones((2 * reach + 1, 2 * reach + 1), dtype=np.uint8)
    return np.asarray(cv2.dilate(cells.astype(np.uint8), square) > 0)
