"""The bag of a mission: all messages sorted by time, with their QoS; images of the extract only."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from node_testing import isolated_graph
from rosbags.interfaces import QosDurability
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import BagError
from shirube_bringup.bag import EXTRACT_MS, MissionBag, is_in_extract
from shirube_bringup.commands.room import main as room
from shirube_bringup.topics import depth_image, stamp_of
from shirube_ros.camera.image import image_from_array
from shirube_ros.quality_of_service import map_profile, pose_profile

BEGIN, END = EXTRACT_MS
PIXELS = np.tile(np.arange(64, dtype=np.uint8), (48, 1))
DEPTH = np.array([[1.0, 2.5004], [np.nan, 0.25]], np.float32)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A bag of a few messages, published from late to early stamps."""
    with isolated_graph() as graph:
        node = graph.node('simulation')
        now = [BEGIN]
        bag = MissionBag(node, tmp_path / 'mission', lambda: now[0])
        say = {
            topic: node.create_publisher(kind, topic, profile())
            for topic, kind, profile in (
                ('/odom', Odometry, pose_profile),
                ('/ground_truth', PoseStamped, pose_profile),
                ('/cmd_vel', TwistStamped, pose_profile),
                ('/reward_planner/map', OccupancyGrid, map_profile),
                ('/floor/image_raw', Image, pose_profile),
                ('/depth/image', Image, pose_profile),
            )
        }
        assert graph.spin_until(lambda: all(p.get_subscription_count() for p in say.values()))
        for time in (END, END - 20, BEGIN, BEGIN - 20):
            now[0] = time
            header = Header(stamp=stamp_of(time), frame_id='map')
            said = len(bag._messages)
            say['/odom'].publish(Odometry(header=header))
            say['/ground_truth'].publish(PoseStamped(header=header))
            say['/cmd_vel'].publish(TwistStamped())
            say['/reward_planner/map'].publish(OccupancyGrid(header=header))
            say['/floor/image_raw'].publish(image_from_array(PIXELS, header))
            say['/depth/image'].publish(depth_image(DEPTH, header))
            wanted = said + (6 if BEGIN <= time < END else 4)
            assert graph.spin_until(lambda wanted=wanted: len(bag._messages) >= wanted)
        graph.spin_until(lambda: False, 0.2)
        assert bag.write() == 20
        with pytest.raises(BagError, match='exists already'):
            bag.write()
    return tmp_path / 'mission'


def test_messages_are_sorted_by_time(path: Path) -> None:
    with BagReader(path) as bag:
        order = [(message.stamp_ns, message.topic) for message in bag.messages(list(bag.topics))]
    assert sorted(order) == order
    assert len({stamp for stamp, _ in order}) == 4


def test_what_was_latched_is_latched(path: Path) -> None:
    with BagReader(path) as bag:
        latched = {
            name
            for name, topic in bag.topics.items()
            if any(each.durability is QosDurability.TRANSIENT_LOCAL for each in topic.qos)
        }
    assert latched == {'/reward_planner/map'}


def test_pictures_are_those_of_the_extract_and_can_be_read(path: Path) -> None:
    with BagReader(path) as bag:
        pictures = [bag.decode(message) for message in bag.messages(['/floor/image_raw/compressed'])]
        depths = [bag.decode(message) for message in bag.messages(['/depth/image'])]
    assert len(pictures) == len(depths) == 2
    for picture in pictures:
        pixels = cv2.imdecode(picture.data, cv2.IMREAD_GRAYSCALE)
        assert np.abs(pixels.astype(int) - PIXELS).max() <= 8
    for depth in depths:
        assert depth.encoding == '16UC1'
        assert depth.data.view(np.uint16).reshape(2, 2).tolist() == [[1000, 2500], [0, 250]]


def test_the_extract_begins_with_its_first_and_ends_before_its_last_instant() -> None:
    inside = [is_in_extract((1000 + 1e-3 * time) * 1e9) for time in (BEGIN - 1, BEGIN, END - 1, END)]
    assert inside == [False, True, True, False]


def test_an_existing_bag_is_reported_before_the_mission(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = tmp_path / 'bag'
    bag.mkdir()
    assert room([str(tmp_path / 'run'), '--record', str(bag)]) == 1
    error = capsys.readouterr().err
    assert error == f'room: {bag}: exists already; remove it or choose another name for the bag\n'
    assert not (tmp_path / 'run').exists()
