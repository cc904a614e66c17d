"""A written bag is complete and readable by other tools, or it does not exist."""

import numpy as np
import pytest
import yaml

from shirube_bags.bag_reader import BagReader, jazzy_types
from shirube_bags.bag_writer import BagWriter
from shirube_bags.errors import BagError


def read(path):
    with BagReader(path) as bag:
        return [(each.topic, each.stamp_ns, bag.decode(each)) for each in bag.messages()]


def test_what_was_written_is_read_back_equal(tmp_path, messages):
    written = [('/text', 3, 'std_msgs/msg/String', messages.text('three'))]
    written += [('/image_raw', stamp, 'sensor_msgs/msg/Image', messages.image(stamp)) for stamp in (5, 10**18)]
    with BagWriter(tmp_path / 'bag') as bag:
        for topic, stamp, msgtype, message in written:
            bag.write(topic, msgtype, message, stamp)
        assert bag.message_count == 3
    found = read(tmp_path / 'bag')
    assert [each[:2] for each in found] == [each[:2] for each in written]
    assert found[0][2] == written[0][3]
    for (_, _, left), (_, _, _, right) in zip(found[1:], written[1:]):
        assert left.header == right.header
        np.testing.assert_array_equal(left.data, right.data)


def test_serialized_messages_are_written_as_they_are(tmp_path, messages):
    raw = bytes(jazzy_types().serialize_cdr(messages.text('raw'), 'std_msgs/msg/String'))
    with BagWriter(tmp_path / 'bag') as bag:
        bag.write_raw('/text', 'std_msgs/msg/String', raw, 7)
    with BagReader(tmp_path / 'bag') as bag:
        assert [each.raw for each in bag.messages()] == [raw]


def test_the_bag_appears_only_when_it_is_complete(tmp_path, messages):
    with BagWriter(tmp_path / 'made' / 'bag') as bag:
        bag.write('/text', 'std_msgs/msg/String', messages.text('x'), 1)
        assert not (tmp_path / 'made' / 'bag').exists()
    assert [each.name for each in (tmp_path / 'made').iterdir()] == ['bag']
    assert {each.name for each in (tmp_path / 'made' / 'bag').iterdir()} == {'bag.mcap', 'metadata.yaml'}


def test_nothing_is_left_after_an_error(tmp_path, messages):
    def write():
        with BagWriter(tmp_path / 'bag') as bag:
            bag.write('/text', 'std_msgs/msg/String', messages.text('x'), 1)
            raise RuntimeError('power cut')

    with pytest.raises(RuntimeError, match='power cut'):
        write()
    assert list(tmp_path.iterdir()) == []


def test_the_metadata_offers_reliable_topics_and_latched_maps(tmp_path, messages):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.write('/text', 'std_msgs/msg/String', messages.text('x'), 1)
        bag.declare('/map', 'nav_msgs/msg/OccupancyGrid')
    metadata = yaml.safe_load((tmp_path / 'bag' / 'metadata.yaml').read_text())['rosbag2_bagfile_information']
    profiles = {
        each['topic_metadata']['name']: each['topic_metadata']['offered_qos_profiles'][0]
        for each in metadata['topics_with_message_count']
    }
    assert {each['reliability'] for each in profiles.values()} == {'reliable'}
    assert profiles['/text']['durability'] == 'volatile'
    assert profiles['/map']['durability'] == 'transient_local'
    assert metadata['storage_identifier'] == 'mcap'
    assert metadata['message_count'] == 1


def test_chunks_are_compressed(tmp_path, messages):
    image = messages.image(0, side=400)
    image.data[:] = 7
    with BagWriter(tmp_path / 'bag') as bag:
        for stamp in range(20):
            bag.write('/image_raw', 'sensor_msgs/msg/Image', image, stamp)
    assert (tmp_path / 'bag' / 'bag.mcap').stat().st_size < 20 * image.data.size / 50


def test_a_place_that_cannot_be_written_is_refused_in_one_line_and_a_closed_bag_refuses_messages(tmp_path, messages):
    with pytest.raises(BagError, match='exists already; remove it'):
        BagWriter(tmp_path)
    (tmp_path / 'file').write_text('')
    with pytest.raises(BagError, match='cannot be created') as error, BagWriter(tmp_path / 'file' / 'bag'):
        pass
    assert '\n' not in str(error.value)
    with pytest.raises(BagError, match='not open'):
        BagWriter(tmp_path / 'bag').write('/text', 'std_msgs/msg/String', messages.text('x'), 1)


@pytest.mark.parametrize(
    ('topic', 'msgtype', 'stamp', 'message'),
    [
        ('/other', 'my_msgs/msg/Thing', 1, "unknown type 'my_msgs/msg/Thing'"),
        ('/text', 'std_msgs/msg/Int32', 1, 'has type std_msgs/msg/String'),
        ('/other', 'std_msgs/msg/Header', 1, 'is not a valid std_msgs/msg/Header'),
        ('/text', 'std_msgs/msg/String', -1, 'negative'),
    ],
)
def test_a_wrong_message_is_refused_in_one_line(tmp_path, messages, topic, msgtype, stamp, message):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.write('/text', 'std_msgs/msg/String', messages.text('x'), 1)
        with pytest.raises(BagError, match=message) as error:
            bag.write(topic, msgtype, messages.text('y'), stamp)
    assert '\n' not in str(error.value)
