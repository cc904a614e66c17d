"""The recorded drive through a furnished room, mapped and compared with the true map.

The bag `bags/room_drive` goes through depth (two or three cameras), voxels and global map as in the node, with the
node's defaults. Precision is the share of the occupied cells that are solid, recall the share of the solid cells that
were seen and are occupied; each with a tolerance of 0, 1 and 2 cells of 5 cm. Times are CPU time on one core.
"""

from collections.abc import Callable

import cv2
import numpy as np
from _figures import Figure, count, rate, time
from _harness import Option, Run, progress, run_benchmark, use_one_core
from _room_drive import RoomBag, load_room_bag, replay, score, seen_cells
from _voxel_scenes import add_spurious_depths
from numpy.typing import NDArray

from reward_planner.core.depth.stereo_pair import PairMatcher, pair_from_projections
from reward_planner.core.depth.trinocular_depth import TrinocularDepth, depth_from_disparity
from reward_planner.core.occupancy_map import FREE, OCCUPIED, OccupancyMap
from reward_planner.core.settings import DepthSettings, VoxelSettings
from scene_simulator.room.room_drive import RoomDrive

PHANTOMS, PATCH, PHANTOM_DEPTHS = 0.03, 3, (0.4, 6.0)
CELL_PIXELS = 5
COLOURS = {
    'unknown': (200, 200, 200),
    'free, and it is': (255, 255, 255),
    'occupied, and it is': (0, 100, 0),
    'occupied, but free': (255, 0, 0),
    'free, but solid': (0, 0, 255),
    'seen and solid, but unknown': (0, 160, 255),
}
"""Blue, green, red."""


def methods(bag: RoomBag, scene: RoomDrive) -> dict[str, Callable[..., NDArray[np.float32]]]:
    """Return what gives depth of an instant, by name."""
    left = bag.projections['left']
    first, second = (pair_from_projections(left, bag.projections[name]) for name in ('right', 'top'))
    pair = PairMatcher(first, DepthSettings())
    union = TrinocularDepth(first, second, DepthSettings(fusion='union'))
    agreement = TrinocularDepth(first, second, DepthSettings(fusion='agreement'))
    rng = np.random.default_rng(1)
    boxes, rig = scene.room.boxes, scene.rig
    return {
        'three cameras, union': lambda i: union.compute(*i.images).depth,
        'three cameras, agreement': lambda i: agreement.compute(*i.images).depth,
        'two cameras': lambda i: depth_from_disparity(pair.match(*i.images[:2]), first),
        'true depth': lambda i: boxes.depth_image(rig.camera, rig.views(i.truth)['left']),
        'true depth, 3 % phantoms': lambda i: add_spurious_depths(
            boxes.depth_image(rig.camera, rig.views(i.truth)['left']), PHANTOMS, PATCH, PHANTOM_DEPTHS, rng
        ),
    }


THREE = 'three cameras, union'


def picture(
    occupancy: NDArray[np.int8], truth: OccupancyMap, seen: NDArray[np.bool_], bag: RoomBag
) -> NDArray[np.uint8]:
    """Return the map against the truth with the way driven and a key, north up, shape (height, width, 3)."""
    solid, free, occupied = truth.occupied(), occupancy == FREE, occupancy == OCCUPIED
    image = np.full((*truth.frame.shape, 3), COLOURS['unknown'], dtype=np.uint8)
    for name, cells in (
        ('free, and it is', free),
        ('occupied, and it is', occupied),
        ('occupied, but free', occupied & ~solid),
        ('free, but solid', free & solid),
        ('seen and solid, but unknown', seen & ~free & ~occupied),
    ):
        image[cells] = COLOURS[name]
    large = image.repeat(CELL_PIXELS, axis=0).repeat(CELL_PIXELS, axis=1)
    corner = (truth.frame.origin_x, truth.frame.origin_y)
    places = np.array([(instant.truth.x, instant.truth.y) for instant in bag.instants])
    way = np.round((places - corner) / truth.frame.resolution * CELL_PIXELS).astype(np.int32)
    cv2.polylines(large, [way], False, (160, 0, 160), 2)
    strip = np.full((20 * len(COLOURS) + 8, large.shape[1], 3), 255, dtype=np.uint8)
    for i, (name, colour) in enumerate(COLOURS.items()):
        cv2.rectangle(strip, (8, 20 * i + 6), (24, 20 * i + 20), colour, -1)
        cv2.rectangle(strip, (8, 20 * i + 6), (24, 20 * i + 20), (0, 0, 0), 1)
        cv2.putText(strip, name, (34, 20 * i + 18), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (0, 0, 0), 1, cv2.LINE_AA)
    return np.vstack([large[::-1], strip])


def shares(of_cells: tuple[float, ...]) -> Figure:
    """Return shares with a tolerance of 0, 1, 2 cells in per cent."""
    values = {f'{reach} cells': (100 * share, 0.0) for reach, share in enumerate(of_cells)}
    return Figure('count', ', '.join(f'{100 * share:.1f}' for share in of_cells), values, 'higher')


def main(run: Run, instants: int, png: str) -> None:
    """Map the drive by all kinds of depth."""
    use_one_core()
    bag, scene = load_room_bag(), RoomDrive()
    del bag.instants[instants:]
    truth, seen = bag.truth, seen_cells(bag, bag.truth, scene)
    heads = 'depth by | precision: 0, 1, 2 cells % | recall: the same % | free cells solid | overlap mm'
    table = run.table('Maps', heads, 'with unknown ground mm')
    stages = 'depth', 'mapping'
    times = run.table('Times of one frame', 'depth by | depth ms: median / 95 % | points, voxels and maps ms')
    ways = {name: (depth_of, VoxelSettings()) for name, depth_of in methods(bag, scene).items()}
    for rule in ('count', 'range_normalised'):
        ways[f'{THREE}, rule {rule}'] = (ways[THREE][0], VoxelSettings(rule=rule))
    for name, (depth_of, voxels) in progress(ways.items()):
        done = replay(bag, truth, scene, depth_of, voxels)
        result = score(done.occupancy, truth, seen, scene)
        gaps = (count(1e3 * gap, '.0f', better='lower') for gap in (result.overlap, result.unseen_overlap))
        solid = rate(result.false_free[0], result.free, 'lower')
        table.add(name, shares(result.precision), shares(result.recall), solid, *gaps)
        if 'cameras' in name and 'rule' not in name:
            times.add(name, *(time(done.milliseconds[stage][2:]) for stage in stages))
        if png and name == THREE:
            cv2.imwrite(png, picture(done.occupancy, truth, seen, bag))


if __name__ == '__main__':
    run_benchmark(
        main,
        instants=Option(140, 40, 'of the drive'),
        png=Option('', '', 'draws the map of three cameras (union) against the truth'),
    )
