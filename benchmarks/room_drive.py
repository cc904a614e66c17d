"""The recorded drive through a furnished room, mapped and compared with the true map: `./shirube bench room_drive`.

The bag `bags/room_drive` goes through depth, voxels and global map as in the node, with the node's defaults. Precision
is the share of the occupied cells that are solid, recall the share of the solid cells that were seen and are occupied;
each with a tolerance of 0, 1 and 2 cells of 5 cm. Times are CPU time on one core, OpenCV with one thread.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np
from _room_drive import BAG, DepthOf, Replay, RoomBag, Score, load_room_bag, replay, score, seen_cells
from _timed_answers import use_one_core
from numpy.typing import NDArray
from tqdm import tqdm

from reward_planner.core.depth.depth_settings import DepthSettings
from reward_planner.core.depth.stereo_pair import PairMatcher, pair_from_projections
from reward_planner.core.depth.trinocular_depth import TrinocularDepth, depth_from_disparity
from reward_planner.core.occupancy_map import FREE, OCCUPIED, OccupancyMap
from scene_simulator.box_room import add_spurious_depths
from scene_simulator.room_drive import RoomDrive

PHANTOMS, PATCH, PHANTOM_DEPTHS = 0.03, 3, (0.4, 6.0)
TOLERANCES = '0, 1, 2 cells'
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


def methods(bag: RoomBag, scene: RoomDrive) -> dict[str, DepthOf]:
    """Return what gives depth of an instant, by name."""
    first, second = (
        pair_from_projections(bag.projections['left'], bag.projections[n]) for n in ('right', 'top')
    )
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


def print_scores(results: dict[str, tuple[Replay, Score]]) -> None:
    """Print a line a method."""
    print(
        f'| depth by | precision: {TOLERANCES} | recall: {TOLERANCES} | free cells '
        '| of them solid (deeper than a cell) | overlap | with unknown ground |'
    )
    print('|---|---|---|---|---|---|---|')
    for name, (_, result) in results.items():
        precision, recall = (', '.join(f'{v:.3f}' for v in vs) for vs in (result.precision, result.recall))
        occupied_cells, deep = result.false_free
        print(
            f'| {name} | {precision} | {recall} | {result.free} | {occupied_cells} ({deep}) '
            f'| {1e3 * result.overlap:.0f} mm | {1e3 * result.unseen_overlap:.0f} mm |'
        )


def print_times(results: dict[str, tuple[Replay, Score]]) -> None:
    """Print what a frame takes, stage by stage."""
    print('\n| 320 x 240, one frame | depth ms | points, voxels and maps ms | frames a second |')
    print('|---|---|---|---|')
    for name, (run, _) in results.items():
        if 'cameras' in name:
            depth, mapping = (1e3 * run.seconds[stage] / run.frames for stage in ('depth', 'mapping'))
            print(f'| {name} | {depth:.1f} | {mapping:.1f} | {1e3 / (depth + mapping):.0f} |')


def picture(
    occupancy: NDArray[np.int8], truth: OccupancyMap, seen: NDArray[np.bool_], bag: RoomBag
) -> NDArray[np.uint8]:
    """Return the map against the truth with the way driven and a key, north up, shape (height, width, 3)."""
    occupied_cells, free, occupied = truth.occupied(), occupancy == FREE, occupancy == OCCUPIED
    image = np.full((*truth.frame.shape, 3), COLOURS['unknown'], dtype=np.uint8)
    for name, cells in (
        ('free, and it is', free),
        ('occupied, and it is', occupied),
        ('occupied, but free', occupied & ~occupied_cells),
        ('free, but solid', free & occupied_cells),
        ('seen and solid, but unknown', seen & ~free & ~occupied),
    ):
        image[cells] = COLOURS[name]
    large = np.repeat(np.repeat(image, CELL_PIXELS, axis=0), CELL_PIXELS, axis=1)
    corner = (truth.frame.origin_x, truth.frame.origin_y)
    places = np.array([(instant.truth.x, instant.truth.y) for instant in bag.instants])
    way = np.round((places - corner) / truth.frame.resolution * CELL_PIXELS).astype(np.int32)
    cv2.polylines(large, [way], False, (160, 0, 160), 2)
    return np.vstack([large[::-1], key(large.shape[1])])


def key(width: int) -> NDArray[np.uint8]:
    """Return a strip that names the colours."""
    strip = np.full((20 * len(COLOURS) + 8, width, 3), 255, dtype=np.uint8)
    for i, (name, colour) in enumerate(COLOURS.items()):
        cv2.rectangle(strip, (8, 20 * i + 6), (24, 20 * i + 20), colour, -1)
        cv2.rectangle(strip, (8, 20 * i + 6), (24, 20 * i + 20), (0, 0, 0), 1)
        cv2.putText(strip, name, (34, 20 * i + 18), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (0, 0, 0), 1, cv2.LINE_AA)
    return strip


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--bag', type=Path, default=BAG, help='made by record_room_bag with its default seed')
    parser.add_argument('--png', type=Path, help='draw the map of three cameras (union) against the truth')
    arguments = parser.parse_args()
    use_one_core()
    bag, scene = load_room_bag(arguments.bag), RoomDrive()
    truth = bag.truth
    if truth is None:
        parser.error(f'{arguments.bag} has no /truth/map')
    seen = seen_cells(bag, truth, scene)
    replay(bag, truth, scene, methods(bag, scene)['two cameras'])  # compiles
    results = {}
    for name, depth_of in tqdm(methods(bag, scene).items(), leave=False):
        run = replay(bag, truth, scene, depth_of)
        results[name] = (run, score(run.occupancy, truth, seen, scene))
    print('## A drive through a furnished room\n\n`./shirube bench room_drive`\n')
    print_scores(results)
    print_times(results)
    if arguments.png is not None:
        occupancy = results['three cameras, union'][0].occupancy
        cv2.imwrite(str(arguments.png), picture(occupancy, truth, seen, bag))
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
