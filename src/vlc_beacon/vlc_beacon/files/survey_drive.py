"""Images of a recorded drive with known camera poses."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import BagError
from shirube_bags.trajectory import can_interpolate, interpolate
from shirube_bags.trajectory_files import load_bag_trajectory, load_header_stamps
from shirube_core.geometry import CameraMount, PinholeCamera
from shirube_ros.camera.image import array_from_compressed_image, array_from_image
from shirube_ros.camera.info import camera_from_camera_info, check_image_size

_NANOSECONDS = 1e9
_GAP_MAX_NS = 200_000_000
"""Maximum gap between poses for interpolation."""


@dataclass(frozen=True)
class DriveTopics:
    """Topics of the bag; without an IMU, whose orientation gives roll and pitch, those of the pose are used."""

    image: str
    camera_info: str
    pose: str
    imu: str


@dataclass(frozen=True)
class DriveImage:
    """An image with a known camera pose.

    Attributes:
        stamp: time since the first image [s].
        pixels: grey image, shape (h, w).
        position: camera position in the map, shape (3,) [m].
        rotation: camera rotation ``R_map_camera``, shape (3, 3).
    """

    stamp: float
    pixels: NDArray[np.uint8]
    position: NDArray[np.float64]
    rotation: NDArray[np.float64]


def load_camera(bag: BagReader, topic: str) -> PinholeCamera:
    """Return the calibration of a bag's images; raises `BagError` or `CameraInfoError`."""
    for raw in bag.messages([topic]):
        return camera_from_camera_info(bag.decode(raw), topic)
    raise BagError(f'{bag.path}: {topic} is empty; record the calibration too')


def drive_images(
    bag: BagReader, topics: DriveTopics, mount: CameraMount, camera: PinholeCamera
) -> Iterator[DriveImage]:
    """Yield the images of an open bag with known poses.

    Raises:
        BagError: a topic is missing or corrupted, or no image has a pose.
        MessageError: an image cannot be decoded.
    """
    stamps = load_header_stamps(bag, topics.image)
    known, positions, rotations = _base_poses(bag, topics, stamps)
    if not known.any():
        raise BagError(f'{bag.path}: {topics.pose} has no pose at the stamp of any image; use another topic')
    camera_positions = positions + rotations @ np.array(mount.xyz)
    orientations = rotations @ mount.rotation
    indices = np.cumsum(known) - 1
    for number, raw in enumerate(bag.messages([topics.image])):
        if known[number]:
            k = indices[number]
            seconds = float((stamps[number] - stamps[0]) / _NANOSECONDS)
            pixels = _grey(bag.decode(raw), raw.msgtype, topics.image)
            check_image_size(camera, pixels.shape, topics.image, topics.camera_info)
            yield DriveImage(seconds, pixels, camera_positions[k], orientations[k])


def _base_poses(
    bag: BagReader, topics: DriveTopics, stamps: NDArray[np.int64]
) -> tuple[NDArray[np.bool_], NDArray[np.float64], NDArray[np.float64]]:
    """Return the mask of stamps with a pose, and positions (n, 3) and ``R_map_base`` (n, 3, 3) at them."""
    trajectory = load_bag_trajectory(bag, topics.pose)
    known = can_interpolate(trajectory, stamps, _GAP_MAX_NS)
    tilts = _load_tilts(bag, topics.imu) if topics.imu else None
    if tilts is not None:
        known &= (tilts[0][0] <= stamps) & (stamps <= tilts[0][-1])
    poses = interpolate(trajectory, stamps[known])
    orientations = Rotation.from_quat(poses.quaternions)
    if tilts is not None and known.any():
        # Yaw is from the planar pose, roll and pitch from the IMU.
        times = (stamps[known] - tilts[0][0]) / _NANOSECONDS
        imu_times = (tilts[0] - tilts[0][0]) / _NANOSECONDS
        roll, pitch = (np.interp(times, imu_times, axis) for axis in tilts[1].T)
        yaws = orientations.as_euler('xyz')[:, 2]
        orientations = Rotation.from_euler('xyz', np.column_stack([roll, pitch, yaws]))
    return known, poses.positions, orientations.as_matrix()


def _load_tilts(bag: BagReader, topic: str) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return stamps (n,) [ns] and roll and pitch (n, 2) [rad]."""
    stamps = load_header_stamps(bag, topic)
    orientations = [bag.decode(raw).orientation for raw in bag.messages([topic])]
    if not orientations:
        raise BagError(f'{bag.path}: {topic} is empty; use another topic')
    quaternions = np.array([(turn.x, turn.y, turn.z, turn.w) for turn in orientations])
    if not (np.isfinite(quaternions).all() and np.abs(quaternions).max(axis=1).min() > 0.0):
        raise BagError(f'{bag.path}: {topic} has no orientation; use another topic, or none with ""')
    return stamps, Rotation.from_quat(quaternions).as_euler('xyz')[:, :2]


def _grey(message: object, msgtype: str, topic: str) -> NDArray[np.uint8]:
    convert = array_from_compressed_image if msgtype.endswith('CompressedImage') else array_from_image
    pixels = convert(message, topic)
    return pixels if pixels.ndim == 2 else np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY), np.uint8)
