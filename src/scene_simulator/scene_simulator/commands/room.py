"""Records a drive through a furnished room as a bag, with ground truth poses and map."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scene_simulator import messages
from scene_simulator.commands.recording import (
    START_NS,
    Entry,
    bag_parser,
    odometry_of_drive,
    run_recording,
    write_entries,
)
from scene_simulator.errors import SceneError
from scene_simulator.room.room_drive import RoomDrive

PICTURE_RATE, POSE_RATE = 5, 20  # [Hz]
JPEG_QUALITY = 70
RESOLUTION = 0.05  # resolution of the true map [m]; cell borders are at its multiples
HEIGHTS = (0.1, 1.2)  # height range of the obstacles in the true map [m]
_WHEEL_NOISE = 3
_BORDER = 4  # cells of the true map outside of the room


def record_room_bag(arguments: Sequence[str] | None = None) -> int:
    """``record_room_bag``: render a drive through a furnished room as a bag; the same seed gives the same bag."""
    use = 'furniture and noise'
    parser = bag_parser('record_room_bag', record_room_bag.__doc__, 28.0, RoomDrive.seed, use)
    options = parser.parse_args(arguments)

    def record() -> tuple[Iterator[int], int, str]:
        instants = record_room_drive(RoomDrive(options.seed), options.bag, options.seconds)
        total = math.ceil(options.seconds * PICTURE_RATE)
        return instants, total, f'{options.bag}: {options.seconds} s of a drive through a room'

    return run_recording('record_room_bag', record, 'instant')


def record_room_drive(scene: RoomDrive, path: Path, seconds: float) -> Iterator[int]:
    """Record a drive; yield the number of each instant after its three pictures are written.

    Raises:
        BagError: the bag cannot be written.
        SceneError: the length is not positive, or the room cannot be furnished.
    """
    if not 0.0 < seconds < math.inf:
        raise SceneError(f'the recording is {seconds} s long: give a positive number of seconds')
    message = messages.occupancy_grid(*true_map(scene), RESOLUTION, START_NS)
    rng = np.random.default_rng((scene.seed, _WHEEL_NOISE))
    return write_entries(
        path,
        '/ground_truth',
        [(START_NS, '/truth/map', 'nav_msgs/msg/OccupancyGrid', message)],
        odometry_of_drive(scene.drive.pose_at, seconds, rng),
        _pose_entries(scene, seconds),
        _picture_entries(scene, seconds),
    )


def true_map(scene: RoomDrive) -> tuple[NDArray[np.int8], tuple[float, float]]:
    """Return the true occupancy, shape (rows, columns), 0 or 100, and its lower left corner [m]."""
    size = np.array(scene.size)
    first = np.floor(size[:2] / RESOLUTION).astype(int) - _BORDER
    last = np.ceil(size[3:5] / RESOLUTION).astype(int) + _BORDER
    x, y = (RESOLUTION * first).tolist()
    columns, rows = (last - first).tolist()
    solid = scene.room.boxes.solid_cells((x, y), RESOLUTION, (rows, columns), HEIGHTS)
    return np.where(solid, 100, 0).astype(np.int8), (x, y)


def _times(rate: int, seconds: float) -> Iterator[tuple[int, float, int]]:
    """Yield number, time since the start [s] and stamp [ns]."""
    for index in range(math.ceil(seconds * rate)):
        yield index, index / rate, START_NS + round(index * 1e9 / rate)


def _pose_entries(scene: RoomDrive, seconds: float) -> Iterator[Entry]:
    for index, time, stamp in _times(POSE_RATE, seconds):
        message = messages.pose_stamped(scene.localizer_pose(index, time), 'map', stamp)
        yield stamp, '/pose', 'geometry_msgs/msg/PoseStamped', message


def _picture_entries(scene: RoomDrive, seconds: float) -> Iterator[Entry]:
    """Yield the pictures of each instant, their calibrations, and the true pose."""
    for index, time, stamp in _times(PICTURE_RATE, seconds):
        for name, picture in scene.pictures(index, time).items():
            frame = f'{name}_camera_optical_frame'
            info = messages.camera_info(scene.rig.camera, frame, stamp, projection=scene.rig.projections[name])
            image = messages.compressed_image(picture, frame, stamp, JPEG_QUALITY)
            yield stamp, f'/{name}/camera_info', 'sensor_msgs/msg/CameraInfo', info
            yield stamp, f'/{name}/image_rect/compressed', 'sensor_msgs/msg/CompressedImage', image
        truth = messages.pose_stamped(scene.drive.pose_at(time), 'map', stamp)
        yield stamp, '/ground_truth', 'geometry_msgs/msg/PoseStamped', truth
