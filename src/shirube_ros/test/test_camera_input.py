"""Images and their CameraInfo through real subscriptions."""

from array import array
from typing import Any

import cv2
import numpy as np
import pytest
from node_testing import IsolatedGraph
from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from shirube_core.geometry import PinholeCamera
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.camera.image import image_from_array
from shirube_ros.camera.info import camera_from_camera_info
from shirube_ros.camera.input import ImageInput

PIXELS = np.random.default_rng(2).integers(0, 256, (40, 50), dtype=np.uint8)
PNG = array('B', cv2.imencode('.png', PIXELS)[1].tobytes())
INFO = CameraInfo(width=50, height=40, k=[60.0, 0.0, 25.0, 0.0, 60.0, 20.0, 0.0, 0.0, 1.0])
CAMERA = PinholeCamera(50, 40, 60.0, 60.0, 25.0, 20.0)


class Pair:
    """A camera and a node that looks through it."""

    def __init__(self, graph: IsolatedGraph, transport: str, *remappings: str, **parameters: Any) -> None:
        self._graph = graph
        arguments = ['--ros-args', *(word for rule in remappings for word in ('-r', rule))]
        self.viewer = graph.add(lambda **options: Node('viewer', cli_args=arguments, **options), **parameters)
        self.guard = CallbackGuard(self.viewer)
        self.seen: list[tuple[Header, np.ndarray, PinholeCamera]] = []
        topics, take = ('image_raw', 'camera_info'), lambda *image: self.seen.append(image)
        ImageInput(self.viewer, self.guard, topics, transport, camera_from_camera_info, take)
        self._camera = graph.node('camera')

    def send(self, topic: str, message: Any) -> None:
        publisher = self._camera.create_publisher(type(message), topic, 10)
        assert self._graph.spin_until(lambda: publisher.get_subscription_count() == 1)
        before = self._received()
        publisher.publish(message)
        assert self._graph.spin_until(lambda: self._received() > before)

    def subscriptions_of(self, topic: str) -> int:
        return sum(each.topic_name == topic for each in self.viewer.subscriptions)

    def _received(self) -> int:
        return sum(count.received for count in self.guard.counts.values())

    def refusals(self) -> list[str]:
        return [reason for count in self.guard.counts.values() for reason in count.rejected]


def test_a_raw_image_arrives_with_its_camera(graph: IsolatedGraph) -> None:
    pair = Pair(graph, 'raw')
    pair.send('camera_info', INFO)
    pair.send('image_raw', image_from_array(PIXELS, Header(frame_id='optical')))
    header, pixels, camera = pair.seen[0]
    assert (header.frame_id, camera) == ('optical', CAMERA)
    np.testing.assert_array_equal(pixels, PIXELS)


@pytest.mark.parametrize(('remapping', 'topic'), [('a:=b', '/image_raw'), ('image_raw:=/belly', '/belly')])
def test_a_compressed_image_arrives_also_remapped(graph: IsolatedGraph, remapping: str, topic: str) -> None:
    pair = Pair(graph, 'compressed', remapping)
    pair.send('camera_info', INFO)
    pair.send(f'{topic}/compressed', CompressedImage(format='png', data=PNG))
    np.testing.assert_array_equal(pair.seen[0][1], PIXELS)


@pytest.mark.parametrize('first', ['raw', 'compressed'])
def test_of_two_kinds_the_first_is_kept_and_the_other_no_longer_subscribed_to(graph: IsolatedGraph, first: str) -> None:
    pair = Pair(graph, 'auto')
    messages = {
        'raw': ('image_raw', image_from_array(PIXELS, Header())),
        'compressed': ('image_raw/compressed', CompressedImage(data=PNG)),
    }
    pair.send('camera_info', INFO)
    pair.send(*messages[first])
    assert len(pair.seen) == 1
    subscribed = {topic for topic in ('/image_raw', '/image_raw/compressed') if pair.subscriptions_of(topic)}
    assert subscribed == {f'/{messages[first][0]}'}
    pair.send(*messages[first])
    assert len(pair.seen) == 2


def test_a_broken_image_does_not_choose_its_kind(graph: IsolatedGraph) -> None:
    pair = Pair(graph, 'auto')
    pair.send('camera_info', INFO)
    pair.send('image_raw/compressed', CompressedImage(data=array('B', b'no picture')))
    pair.send('image_raw', image_from_array(PIXELS, Header()))
    assert len(pair.seen) == 1


def test_bad_images_and_calibrations_are_counted_and_the_next_good_one_works(graph: IsolatedGraph) -> None:
    pair = Pair(graph, 'raw')
    good = image_from_array(PIXELS, Header())
    pair.send('image_raw', good)
    pair.send('camera_info', INFO)
    pair.send('image_raw', image_from_array(PIXELS[1:], Header()))
    pair.send('image_raw', Image(encoding='32FC1'))
    pair.send('camera_info', CameraInfo())
    pair.send('image_raw', good)
    assert pair.seen == []
    words = ['without a valid camera_info', '50 x 39 px', '32FC1', 'not calibrated']
    assert all(any(word in reason for reason in pair.refusals()) for word in words)
    pair.send('camera_info', INFO)
    pair.send('image_raw', good)
    assert len(pair.seen) == 1


def test_quality_of_service_is_best_effort_and_can_be_overridden(graph: IsolatedGraph) -> None:
    default = Pair(graph, 'raw').viewer
    override = {'qos_overrides./image_raw.subscription.reliability': 'reliable'}
    overridden = Pair(graph, 'raw', **override).viewer

    def reliabilities(node: Node) -> dict[str, ReliabilityPolicy]:
        return {part.topic_name: part.qos_profile.reliability for part in node.subscriptions}

    assert reliabilities(default)['/image_raw'] == ReliabilityPolicy.BEST_EFFORT
    assert reliabilities(overridden)['/image_raw'] == ReliabilityPolicy.RELIABLE
