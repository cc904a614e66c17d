"""Subscription to three rectified cameras in an L."""

from __future__ import annotations

from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from std_msgs.msg import Header

from reward_planner.core.depth.depth_points import points_from_depth_image
from reward_planner.core.depth.depth_settings import DepthSettings
from reward_planner.core.depth.trinocular_rig import TrinocularRig
from reward_planner.core.navigator import SensorFrame
from reward_planner.inputs.frame_callback import FrameCallback
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.camera.info import RigCamera, rig_camera
from shirube_ros.camera.input import ImageInput
from shirube_ros.stamps import StampSynchronizer

_CAMERAS = ('left', 'right', 'top')
_SYNC_TOLERANCE = 0.005  # largest difference of stamps of one trigger [s]


class TrinocularInput:
    """Subscribes to ``image_rect`` and ``camera_info`` of ``left/``, ``right/`` and ``top/`` and synchronizes them.

    Attributes:
        groups: images that wait for others of the same stamp, and the number of dropped ones.
    """

    def __init__(
        self,
        node: Node,
        guard: CallbackGuard,
        transport: str,
        settings: DepthSettings,
        on_frame: FrameCallback,
    ) -> None:
        """Subscribe.

        Args:
            node: node that subscribes.
            guard: counts the messages and catches their errors.
            transport: ``raw``, ``compressed`` or ``auto``.
            settings: settings of stereo matching.
            on_frame: called for each three valid images.
        """
        self._settings, self._on_frame = settings, on_frame
        self.groups: StampSynchronizer[tuple[Header, NDArray[np.uint8]]] = StampSynchronizer(
            _CAMERAS, _SYNC_TOLERANCE
        )
        self._cameras: dict[str, RigCamera] = {}
        for name in _CAMERAS:
            ImageInput(
                node,
                guard,
                (f'{name}/image_rect', f'{name}/camera_info'),
                transport,
                rig_camera,
                partial(self._take, name),
            )
        self._projections: NDArray[np.float64] | None = None
        self._rig: TrinocularRig | None = None
        self._logger = node.get_logger()

    def _take(self, name: str, header: Header, pixels: NDArray[np.uint8], camera: RigCamera) -> None:
        grey = pixels if pixels.ndim == 2 else np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY))
        stamp = header.stamp.sec + 1e-9 * header.stamp.nanosec
        self._cameras[name] = camera
        group = self.groups.put(name, stamp, (header, grey))
        if group is None:
            return
        rig = self._rig_of(np.array([self._cameras[each].projection for each in _CAMERAS]))
        images = [image for _, image in group]
        was_mirrored = rig.is_mirrored
        depth = rig.compute(images[0], images[1], images[2]).depth
        if rig.is_mirrored and not was_mirrored:
            self._logger.warning(
                'P[1, 3] of top/camera_info has the wrong sign: the images show the camera on the other side of the '
                'left one; the images are used'
            )
        left = self._cameras['left'].camera
        self._on_frame(group[0][0], SensorFrame(points_from_depth_image(depth, left), left.fx))

    def _rig_of(self, projections: NDArray[np.float64]) -> TrinocularRig:
        """Return the rig for projection matrices P, shape (3, 3, 4); a new one if the calibration changed."""
        is_same = self._projections is not None and np.array_equal(self._projections, projections)
        if self._rig is None or not is_same:
            self._rig = TrinocularRig(projections, self._settings)
            self._projections = projections
        return self._rig
