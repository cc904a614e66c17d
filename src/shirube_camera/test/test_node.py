"""The node with a folder, a video, and a camera that is unplugged and refuses settings."""

from time import monotonic

import cv2
import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

from shirube_camera import frame_source
from shirube_camera.core.calibration import ShirubeCameraError
from shirube_camera.node import CameraNode
from shirube_core.geometry import PinholeCamera
from shirube_ros.camera.files import calibration_text
from shirube_ros.quality_of_service import sensor_profile

pytestmark = pytest.mark.newest_set_only

PICTURE = np.full((40, 60, 3), (50, 100, 150), np.uint8)


class Camera:
    """OpenCV's capture of a camera that delivers 100 images a second, whose gain is fixed."""

    def __init__(self, *_):
        self.is_plugged, self.values, self.stamp = True, {cv2.CAP_PROP_FPS: 100.0}, monotonic()

    def isOpened(self):
        return self.is_plugged

    def read(self):
        self.stamp += 0.01
        while monotonic() < self.stamp:
            pass
        return self.is_plugged, PICTURE

    def get(self, name):
        return 1e3 * self.stamp if name == cv2.CAP_PROP_POS_MSEC else self.values.get(name, 0.0)

    def set(self, name, value):
        self.values[name] = 7.0 if name == cv2.CAP_PROP_GAIN else value

    def release(self):
        pass


class Receiver:
    """Keeps the messages of topics."""

    def __init__(self, graph, **kinds):
        self.graph, self.node, self.got = graph, graph.node('receiver'), {topic: [] for topic in kinds}
        for topic, kind in kinds.items():
            name = topic.replace('__', '/')
            self.node.create_subscription(kind, name, self.got[topic].append, sensor_profile())

    def wait(self, topic, count=1):
        assert self.graph.spin_until(lambda: len(self.got[topic]) >= count), topic
        return self.got[topic][-1]


@pytest.fixture
def folder(tmp_path):
    for k in range(4):
        cv2.imwrite(str(tmp_path / f'{k}.png'), np.full((40, 60), 10 * k, np.uint8))
    return tmp_path


def test_a_folder_is_split_with_one_stamp_and_the_calibration_of_each_half(graph, folder, tmp_path):
    for side, fx in (('left', 50.0), ('right', 51.0)):
        text = calibration_text(side, PinholeCamera(30, 40, fx, fx, 15.0, 20.0), np.eye(3), np.eye(3, 4))
        (tmp_path / f'{side}.yaml').write_text(text)
    kinds = {'left__image_raw': Image, 'right__image_raw': Image, 'right__camera_info': CameraInfo}
    receiver = Receiver(graph, **kinds)
    graph.add(CameraNode, device=str(folder), loop=True, rate=50.0, split='left_right', calibration_file=str(tmp_path))
    left, _, info = (receiver.wait(topic, 6) for topic in kinds)
    assert (left.width, left.height, left.encoding, info.width, info.k[0]) == (30, 40, 'mono8', 30, 51.0)
    stamps = [{(m.header.stamp.sec, m.header.stamp.nanosec) for m in receiver.got[topic]} for topic in kinds]
    assert len(stamps[0] & stamps[1]) >= 4
    assert {message.data[0] for message in receiver.got['left__image_raw']} <= {0, 10, 20, 30}


def test_a_calibration_of_another_size_is_one_line_and_no_camera_info(graph, folder, tmp_path):
    file = tmp_path / 'camera.yaml'
    file.write_text(calibration_text('c', PinholeCamera(64, 48, 50.0, 50.0, 32.0, 24.0), np.eye(3), np.eye(3, 4)))
    receiver = Receiver(graph, image_raw=Image, camera_info=CameraInfo)
    node = graph.add(CameraNode, device=str(folder), loop=True, rate=50.0, calibration_file=str(file))
    receiver.wait('image_raw', 5)
    assert not receiver.got['camera_info']
    (reason,) = node._guard.counts['image_raw'].rejected
    assert f'60 x 40 px but {file} is for 64 x 48 px' in reason


def test_a_camera_gives_its_stamps_and_what_it_refused_and_comes_back(graph, monkeypatch):
    opened = []
    monkeypatch.setattr(frame_source.cv2, 'VideoCapture', lambda *_: opened.append(Camera()) or opened[-1])
    kinds = {'image_raw__compressed': CompressedImage, 'camera_info': CameraInfo, 'diagnostics': DiagnosticArray}
    receiver = Receiver(graph, **kinds)
    node = graph.add(CameraNode, device='/dev/null', exposure_time=0.002, gain=3.0, encoding='bgr8')
    image = receiver.wait('image_raw__compressed', 20)
    pixels = cv2.imdecode(np.frombuffer(image.data, np.uint8), cv2.IMREAD_UNCHANGED)
    assert np.abs(pixels.astype(int) - PICTURE).max() < 6
    stamp = receiver.got['camera_info'][-1].header.stamp
    age = node.get_clock().now().nanoseconds * 1e-9 - stamp.sec - 1e-9 * stamp.nanosec
    assert abs(monotonic() - age - opened[0].stamp) < 0.1
    status = node.status()
    assert status.message == 'gain is 7, not 3'
    assert status.values['stamps'] == "the driver's"
    assert status.values['exposure time [s]'] == '0.002'
    assert float(status.values['rate [1/s]']) == pytest.approx(100.0, rel=0.1)
    opened[0].is_plugged = False
    assert graph.spin_until(lambda: 'is it unplugged' in node.status().message)
    count = len(receiver.got['camera_info'])
    receiver.wait('camera_info', count + 3)
    assert len(opened) == 2


@pytest.mark.parametrize(
    ('device', 'words'),
    [
        ('/dev/video77', 'does not exist'),
        ('none.mp4', 'does not exist; give a camera'),
        (__file__, 'no camera or video'),
    ],
)
def test_what_is_absent_is_named_and_only_a_camera_is_waited_for(graph, device, words):
    if device.startswith('/dev'):
        node = graph.add(CameraNode, device=device)
        assert graph.spin_until(lambda: words in node.status().message)
        assert node.status().message.endswith('trying again every second')
        return
    with pytest.raises(ShirubeCameraError, match=words):
        graph.add(CameraNode, device=device)
