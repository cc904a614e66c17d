"""The ROS node: images of a camera, a video or a folder, with their calibration."""

import sys
from array import array
from collections import deque
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from threading import Event, Thread
from time import monotonic
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from rclpy.duration import Duration
from rclpy.publisher import Publisher
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from shirube_camera.core.calibration import ShirubeCameraError
from shirube_camera.frame_source import CameraSettings, Frame, FrameSource
from shirube_core.settings import setting
from shirube_ros.camera.files import load_camera_info
from shirube_ros.camera.image import image_from_array, to_grey
from shirube_ros.camera.info import check_image_size
from shirube_ros.diagnostics import Level, Status
from shirube_ros.errors import CameraFileError
from shirube_ros.managed_node import ManagedNode
from shirube_ros.node import run_node
from shirube_ros.quality_of_service import overridable, sensor_profile

_RETRY_PERIOD = 1.0  # of opening a camera that is absent [s]
_AGE_MAX = 1.0  # age of an image beyond which the driver's stamp is of another clock [s]


@dataclass(frozen=True)
class OutputSettings:
    """What is published."""

    split: str = setting('none', 'publish halves in left/ and right/', choices=('none', 'left_right'))
    encoding: str = setting('mono8', 'of image_raw; all localizers use grey', choices=('mono8', 'bgr8'))
    calibration_file: str = setting('', 'YAML; with split, folder of left.yaml and right.yaml; empty: none')
    camera_frame: str = setting('camera_optical_frame', 'frame_id of the messages')
    latency: float = setting(0.03, 'arrival after exposure without stamp', 's', (0.0, 1.0))


class _Output(NamedTuple):
    image: Publisher
    compressed: Publisher
    camera_info: Publisher
    info: CameraInfo
    file: str

    def publish(self, pixels: NDArray[np.uint8], header: Header) -> None:
        """Publish an image; raise a CameraInfoError if its size is not that of the calibration."""
        message = image_from_array(pixels, header)
        if self.image.get_subscription_count():
            self.image.publish(message)
        if self.compressed.get_subscription_count():
            data = array('B', cv2.imencode('.jpg', pixels, (cv2.IMWRITE_JPEG_QUALITY, 90))[1].tobytes())
            form = f'{message.encoding}; jpeg compressed {message.encoding}'
            self.compressed.publish(CompressedImage(header=header, format=form, data=data))
        if self.file:
            check_image_size(self.info, pixels.shape, self.image.topic_name, self.file)
        self.info.header, self.info.height, self.info.width = header, message.height, message.width
        self.camera_info.publish(self.info)


class CameraNode(ManagedNode):
    """Publishes the images of a V4L2 camera, a video file or a folder of images.

    ========================  ==================  =================================================================
    published                 type                when
    ========================  ==================  =================================================================
    ``image_raw``             Image               each image; with ``split``, in ``left/`` and ``right/``
    ``image_raw/compressed``  CompressedImage     each image (JPEG), while somebody subscribes
    ``camera_info``           CameraInfo          each image, from ``calibration_file``; zeros without it
    ========================  ==================  =================================================================

    The stamp is the driver's (for UVC: of the first bytes of the image, on the monotonic clock) where OpenCV passes it
    on, otherwise the arrival less ``latency``; for files the time of publication. Errors are those of `FrameSource` for
    files and of the calibration; a camera that is absent is waited for.
    """

    SETTINGS = (CameraSettings, OutputSettings)
    ERRORS = (ShirubeCameraError, CameraFileError)

    def __init__(self, **options: Any) -> None:
        """Declare the parameters, and start; options are those of ``rclpy.node.Node``."""
        super().__init__('camera', **options)
        self._stop, self._thread = Event(), Thread()
        self.start()

    def configure(self) -> None:
        """Load the calibration and create the publishers."""
        self._settings, self._output = self.settings(CameraSettings), self.settings(OutputSettings)
        self._state, self._refused, self._exposure, self._stamps = 'opening', list[str](), 0.0, 'none yet'
        self._times, self._dropped = deque[float](maxlen=100), 0
        sides = ('',) if self._output.split == 'none' else ('left/', 'right/')
        self._outputs = [self._create_output(side) for side in sides]
        if not self._settings.device.isdecimal() and not self._settings.device.startswith('/dev/'):
            FrameSource(self._settings).close()

    def _create_output(self, side: str) -> _Output:
        file = self._output.calibration_file
        file = str(Path(file) / f'{side[:-1]}.yaml') if file and side else file
        topics = {'image_raw': Image, 'image_raw/compressed': CompressedImage, 'camera_info': CameraInfo}
        image, compressed, camera_info = (
            self.create_publisher(kind, side + topic, sensor_profile(), qos_overriding_options=overridable())
            for topic, kind in topics.items()
        )
        info = load_camera_info(Path(file)) if file else CameraInfo()
        return _Output(image, compressed, camera_info, info, file)

    def activate(self) -> None:
        """Start reading images."""
        self._stop.clear()
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def halt(self) -> None:
        """Release the camera after the current image; OpenCV may wait for one for ten seconds."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(2.0)

    def apply_settings(self) -> None:
        """Set exposure, gain and focus before the next image."""
        self._settings = self.settings(CameraSettings)

    def _run(self) -> None:
        """Read images until the end; open a camera again after it failed."""
        is_live = True
        while is_live and not self._stop.is_set():
            try:
                source = FrameSource(self._settings)
            except ShirubeCameraError as fault:
                self._set_state(f'{fault}; trying again every second')
            else:
                self._guard.run('images', partial(self._read, source))
                source.close()
                is_live = source.is_live
            self._stop.wait(_RETRY_PERIOD)

    def _read(self, source: FrameSource) -> None:
        applied, due = None, monotonic()
        while not self._stop.is_set():
            if applied != self._settings:
                applied, self._refused = self._settings, source.apply(self._settings)
                self._exposure = source.exposure_time
                if self._refused:
                    self.get_logger().warning(f'the camera refused settings: {"; ".join(self._refused)}')
            frame = source.read()
            if frame is None:
                what = 'delivers no images, is it unplugged? Trying again every second'
                self._set_state(f'{self._settings.device} {what if source.is_live else "has ended"}')
                return
            self._set_state('')
            now = frame.stamp or monotonic()
            if frame.stamp and self._times:
                self._dropped += max(round((now - self._times[-1]) * source.rate) - 1, 0)
            self._times.append(now)
            self._publish(frame, self._output.latency if source.is_live else 0.0)
            if not source.is_live:
                due = max(due + 1.0 / source.rate, monotonic())
                self._stop.wait(due - monotonic())

    def _set_state(self, state: str) -> None:
        if state != self._state:
            self._times.clear()
            self.get_logger().warning(state or f'{self._settings.device} delivers images')
        self._state = state

    def _publish(self, frame: Frame, age: float) -> None:
        self._stamps = f'arrival less {age:g} s'
        if 0.0 <= monotonic() - frame.stamp <= _AGE_MAX:
            age, self._stamps = monotonic() - frame.stamp, "the driver's"
        stamp = (self.get_clock().now() - Duration(nanoseconds=round(1e9 * age))).to_msg()
        header = Header(stamp=stamp, frame_id=self._output.camera_frame)
        parts = np.array_split(frame.pixels, len(self._outputs), axis=1)
        for output, pixels in zip(self._outputs, parts, strict=True):
            image = to_grey(pixels) if self._output.encoding == 'mono8' else pixels
            self._guard.run('image_raw', partial(output.publish, image, header))

    def status(self) -> Status:
        """Return the measured rate, dropped images, and what the camera refused."""
        times = [*self._times]
        rate = (len(times) - 1) / (times[-1] - times[0]) if len(times) > 1 and not self._state else 0.0
        values = {'rate [1/s]': f'{rate:.1f}', 'dropped images': str(self._dropped)}
        values |= {'exposure time [s]': f'{self._exposure:g}', 'stamps': self._stamps}
        problems = '; '.join(filter(None, [self._state, *self._refused]))
        level = Level.OK if not problems else Level.ERROR if self._state else Level.WARN
        return Status(level, problems or 'publishing images', values)

    def destroy_node(self) -> None:
        """Release the camera and destroy the node."""
        self.halt()
        super().destroy_node()


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node('camera', CameraNode)


if __name__ == '__main__':
    sys.exit(main())
