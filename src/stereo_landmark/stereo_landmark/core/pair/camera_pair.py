"""A pair of cameras: calibration (fields of ``sensor_msgs/CameraInfo``), rectification, synchronization."""

import math
from collections import deque
from dataclasses import dataclass
from enum import IntEnum
from typing import Generic, TypeVar

import cv2
import numpy as np

from shirube_core.geometry import CameraMount, PinholeCamera
from stereo_landmark.core.arrays import Floats, GreyImage
from stereo_landmark.core.stereo import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

_REMEDY = 'calibrate both cameras as a pair (camera_calibration, stereo)'


@dataclass(frozen=True)
class CameraCalibration:
    """One camera before and after rectification.

    Attributes:
        raw: intrinsics of the raw image.
        rotation: rectification matrix R, row by row, nine numbers; from the camera frame to the rectified frame.
        projection: projection matrix P of the rectified image, row by row, twelve numbers; P[0, 3] is -fx times the
            camera's x [px m].

    Raises:
        StereoLandmarkError: R is not a rotation, or P is not the projection matrix of a rectified camera.
    """

    raw: PinholeCamera
    rotation: tuple[float, ...]
    projection: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.rotation) != 9 or len(self.projection) != 12:
            raise StereoLandmarkError(
                f'rectification_matrix (R) has {len(self.rotation)} and projection_matrix (P) {len(self.projection)} '
                f'numbers instead of 9 and 12; {_REMEDY}'
            )
        if not all(map(math.isfinite, (*self.rotation, *self.projection))):
            raise StereoLandmarkError(f'R or P contains a number that is not finite; {_REMEDY}')
        R = np.array(self.rotation).reshape(3, 3)
        if not np.allclose(R @ R.T, np.eye(3), atol=1e-3):
            raise StereoLandmarkError(f'rectification_matrix (R) is not a rotation; {_REMEDY}')
        fx, _, _, _, _, fy, _, shift_y, *_ = self.projection
        if fx <= 0.0 or fy <= 0.0:
            raise StereoLandmarkError(f'projection_matrix (P) has no focal length; {_REMEDY}')
        if abs(shift_y) > 1e-6 * fy:
            raise StereoLandmarkError(
                'P[1, 3] is not zero: the baseline must be horizontal, not one camera above the other'
            )

    @property
    def width(self) -> int:
        """Image width [px]."""
        return self.raw.width

    @property
    def height(self) -> int:
        """Image height [px]."""
        return self.raw.height

    @property
    def matrix(self) -> Floats:
        """Camera matrix of the rectified image, shape (3, 3)."""
        return np.array(self.projection).reshape(3, 4)[:, :3]

    @property
    def rectified(self) -> PinholeCamera:
        """Intrinsics of the rectified image."""
        fx, _, cx, _, _, fy, cy, *_ = self.projection
        return PinholeCamera(self.width, self.height, fx, fy, cx, cy)

    @property
    def x(self) -> float:
        """Camera position along the rectified x axis [m]."""
        return -self.projection[3] / self.projection[0]


def stereo_rig(left: CameraCalibration, right: CameraCalibration, mount: CameraMount) -> StereoRig:
    """Return the rectified stereo rig.

    Raises:
        StereoLandmarkError: the baseline is zero or negative, or the cameras were not calibrated together.
    """
    return StereoRig(left.rectified, right.rectified, right.x - left.x, mount)


def check_size(image: GreyImage, camera: PinholeCamera | CameraCalibration, name: str = 'the image') -> None:
    """Raise a StereoLandmarkError if an image has not the size of its calibration."""
    if image.shape != (camera.height, camera.width):
        raise StereoLandmarkError(
            f'{name} is {image.shape[1]} x {image.shape[0]} px, the calibration is for '
            f'{camera.width} x {camera.height} px; calibrate at the resolution in use'
        )


class Rectifier:
    """Rectifies the images of one camera."""

    def __init__(self, calibration: CameraCalibration) -> None:
        self._camera = calibration.raw
        rotation = np.array(calibration.rotation).reshape(3, 3)
        self._u, self._v = self._camera.rectification_maps(rotation, calibration.matrix)

    def rectify(self, image: GreyImage) -> GreyImage:
        """Return the rectified image, shape (h, w).

        The border is replicated outside the raw image, because a black border would look like a landmark.

        Args:
            image: raw grey image, shape (h, w).

        Raises:
            StereoLandmarkError: the image size differs from the calibration.
        """
        check_size(image, self._camera)
        rectified = cv2.remap(image, self._u, self._v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(rectified, dtype=np.uint8)


class Side(IntEnum):
    """Camera of the stereo pair."""

    LEFT = 0
    RIGHT = 1


Item = TypeVar('Item')


class StampSynchronizer(Generic[Item]):
    """Pairs the items of two inputs by stamp; the stamps of each input must rise.

    Args:
        tolerance_ns: largest stamp difference of a pair [ns]; 0 for equal stamps. It must be less than half the frame
            interval.
        queue_size: largest number of unpaired items per input.
    """

    def __init__(self, tolerance_ns: int, queue_size: int) -> None:
        self._tolerance_ns = tolerance_ns
        self._queues: tuple[deque[tuple[int, Item]], ...] = (deque(), deque())
        self._queue_size = queue_size

    def add(self, side: int, stamp_ns: int, item: Item) -> tuple[Item, Item] | None:
        """Add an item and return the pair that it completes, None if it completes none.

        Args:
            side: 0 for left, 1 for right.
            stamp_ns: stamp of the item [ns].
            item: the item, such as an image.

        Raises:
            StereoLandmarkError: the queue is full, so the stamps of the inputs do not match.
        """
        own_queue, other_queue = self._queues[side], self._queues[1 - side]
        nearest = min(other_queue, key=lambda other: abs(other[0] - stamp_ns), default=None)
        if nearest is None or abs(nearest[0] - stamp_ns) > self._tolerance_ns:
            own_queue.append((stamp_ns, item))
            self._limit_queue(side)
            return None
        while other_queue and other_queue[0][0] <= nearest[0]:
            other_queue.popleft()
        own_queue.clear()
        return (item, nearest[1]) if side == 0 else (nearest[1], item)

    def _limit_queue(self, side: int) -> None:
        own_queue, other_queue = self._queues[side], self._queues[1 - side]
        if len(own_queue) <= self._queue_size:
            return
        own_queue.popleft()
        names = ('left', 'right')
        if not other_queue:
            raise StereoLandmarkError(
                f'{names[side]} images are received, but no {names[1 - side]} images; check that camera'
            )
        raise StereoLandmarkError(
            'left and right images have no stamps in common; trigger both cameras together, or set approximate_sync'
        )
