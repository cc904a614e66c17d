"""Subscription to a camera's images, raw or compressed, with their calibration."""

from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.camera.image import array_from_compressed_image, array_from_image
from shirube_ros.camera.info import SizedCamera, check_image_size
from shirube_ros.errors import CameraInfoError
from shirube_ros.quality_of_service import overridable, sensor_profile

Camera = TypeVar('Camera', bound=SizedCamera)


class ImageInput(Generic[Camera]):
    """Subscribes to an image and its CameraInfo, and calls back with the pixels and the camera model.

    ``<topic>`` is a sensor_msgs/Image, ``<topic>/compressed`` a sensor_msgs/CompressedImage, ``<info_topic>`` the
    CameraInfo. With ``auto`` the first transport that delivers an image is used and the other one is unsubscribed,
    so that a camera which publishes both delivers each image once and does not compress images that nobody uses.
    """

    def __init__(
        self,
        node: Node,
        guard: CallbackGuard,
        topics: tuple[str, str],
        transport: str,
        read_camera: Callable[[CameraInfo, str], Camera],
        on_image: Callable[[Header, NDArray[np.uint8], Camera], None],
    ) -> None:
        """Subscribe.

        Args:
            node: node that subscribes.
            guard: counts the messages and catches their errors.
            topics: topics of the image and of its CameraInfo.
            transport: ``raw``, ``compressed`` or ``auto``.
            read_camera: converts a CameraInfo and its topic to a camera model, or raises a MessageError.
            on_image: called with header, pixels ((h, w) gray or (h, w, 3) bgr) and camera of each valid image.
        """
        self._topic, self._info_topic = topics
        self._node = node
        self._read_camera = read_camera
        self._on_image = on_image
        self._camera: Camera | None = None
        # Subscribe to CameraInfo first: of two messages that are ready, the executor takes the older subscription.
        self._subscribe(node, guard, CameraInfo, self._info_topic, self._on_camera_info)
        self._subscriptions: dict[str, Subscription] = {}
        if transport != 'raw':
            # A remapping of <topic> must apply to <topic>/compressed, too.
            topic = f'{node.resolve_topic_name(self._topic)}/compressed'
            self._subscriptions['compressed'] = self._subscribe(
                node, guard, CompressedImage, topic, self._on_compressed
            )
        if transport != 'compressed':
            self._subscriptions['raw'] = self._subscribe(node, guard, Image, self._topic, self._on_raw)

    def _subscribe(
        self, node: Node, guard: CallbackGuard, kind: type, topic: str, callback: Callable[..., None]
    ) -> Subscription:
        return node.create_subscription(
            kind, topic, guard.guard(topic, callback), sensor_profile(), qos_overriding_options=overridable()
        )

    def _on_camera_info(self, message: CameraInfo) -> None:
        self._camera = None  # an invalid calibration must not leave the old one in use
        self._camera = self._read_camera(message, self._info_topic)

    def _on_raw(self, message: Image) -> None:
        if 'raw' in self._subscriptions:
            pixels = array_from_image(message, self._topic)
            self._select_transport('raw')
            self._dispatch(message.header, pixels)

    def _on_compressed(self, message: CompressedImage) -> None:
        if 'compressed' in self._subscriptions:
            pixels = array_from_compressed_image(message, f'{self._topic}/compressed')
            self._select_transport('compressed')
            self._dispatch(message.header, pixels)

    def _select_transport(self, kind: str) -> None:
        for other in set(self._subscriptions) - {kind}:
            self._node.destroy_subscription(self._subscriptions.pop(other))

    def _dispatch(self, header: Header, pixels: NDArray[np.uint8]) -> None:
        if self._camera is None:
            raise CameraInfoError(
                f'{self._topic} was received without a valid {self._info_topic}; publish the calibration'
            )
        check_image_size(self._camera, pixels.shape, self._topic, self._info_topic)
        self._on_image(header, pixels, self._camera)
