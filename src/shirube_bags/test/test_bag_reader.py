"""Bags are read completely and in order; invalid ones are rejected in one line with a remedy."""

import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from shirube_bags.bag_reader import BagReader, jazzy_types
from shirube_bags.bag_writer import BagWriter
from shirube_bags.errors import BagError

MCAP = 'drive.mcap'


def refusal(path) -> str:
    with pytest.raises(BagError) as error, BagReader(path) as bag:
        list(bag.messages())
    line = str(error.value)
    assert '\n' not in line
    assert line.startswith(str(path))
    return line


def write_sqlite_bag(path, count=500):
    types = jazzy_types()
    with Writer(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        topic = bag.add_connection('/text', 'std_msgs/msg/String', typestore=types)
        for stamp in range(count):
            text = types.types['std_msgs/msg/String'](f'{stamp} ' * 20)
            bag.write(topic, stamp, types.serialize_cdr(text, 'std_msgs/msg/String'))
    return path


@pytest.mark.parametrize('kind', ['mcap', 'sqlite'])
def test_a_stretch_holds_what_was_received_then_and_nothing_else(bag_path, tmp_path, kind):
    path = bag_path if kind == 'mcap' else write_sqlite_bag(tmp_path / 'bag', 80)
    with BagReader(path) as bag:
        whole = list(bag.messages())
        for first, last in ((0, 0), (7, 31), (40, len(whole) - 1)):
            begin, end = whole[first].stamp_ns, whole[last].stamp_ns
            wanted = [each for each in whole if begin <= each.stamp_ns <= end]
            assert list(bag.messages_between([], begin, end)) == wanted


def test_the_mcap_file_alone_is_a_bag(bag_path):
    with BagReader(bag_path) as whole, BagReader(bag_path / MCAP) as single:
        assert list(whole.messages()) == list(single.messages())


def test_sqlite_bags_are_read_too(tmp_path):
    with BagReader(write_sqlite_bag(tmp_path / 'bag')) as bag:
        assert [bag.decode(each).data.split()[0] for each in bag.messages()] == [str(i) for i in range(500)]


def test_types_defined_by_the_bag_alone_are_decoded(tmp_path):
    types = get_typestore(Stores.ROS2_JAZZY)
    types.register(get_types_from_msg('float64 speed\nstd_msgs/Header header', 'my_msgs/msg/Speed'))
    message = types.types['my_msgs/msg/Speed'](
        1.5, types.types['std_msgs/msg/Header'](types.types['builtin_interfaces/msg/Time'](1, 2), 'map')
    )
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        topic = bag.add_connection('/speed', 'my_msgs/msg/Speed', typestore=types)
        bag.write(topic, 5, types.serialize_cdr(message, 'my_msgs/msg/Speed'))
    with BagReader(tmp_path / 'bag') as bag:
        (found,) = (bag.decode(each) for each in bag.messages())
    assert (found.speed, found.header.stamp.nanosec) == (1.5, 2)


def test_flipped_bytes_are_refused(bag_path):
    data = bytearray((bag_path / MCAP).read_bytes())
    for index in range(200, len(data) // 2, 50):
        data[index] ^= 0xFF
    (bag_path / MCAP).write_bytes(data)
    assert 'truncated or corrupted' in refusal(bag_path)


def test_a_bag_without_messages_is_refused(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.declare('/text', 'std_msgs/msg/String')
    assert 'has no messages' in refusal(tmp_path / 'bag')


def test_an_unknown_topic_is_refused_with_the_known_ones(bag_path):
    with BagReader(bag_path) as bag, pytest.raises(BagError, match='it has /image_raw, /true_pose'):
        bag.select_topics(['/imu'])


def test_bytes_that_are_no_message_are_refused(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.write_raw('/text', 'std_msgs/msg/String', b'\x00\x01\x00\x00\xff\xff\xff\x7f', 1)
    with BagReader(tmp_path / 'bag') as bag, pytest.raises(BagError, match='not a valid std_msgs/msg/String'):
        bag.decode(next(bag.messages()))


def test_errors_of_the_reader_s_user_pass_through(bag_path):
    def use():
        with BagReader(bag_path) as bag:
            for message in bag.messages():
                raise KeyError(message.topic)

    with pytest.raises(KeyError):
        use()


def test_topics_and_times_are_known_and_messages_come_in_the_order_of_their_stamps(bag_path):
    with BagReader(bag_path) as bag:
        counts = {name: topic.message_count for name, topic in bag.topics.items()}
        assert counts == {'/image_raw': 41, '/true_pose': 40}
        assert (bag.message_count, bag.end_ns - bag.start_ns) == (81, 800_000_000)
        stamps = [each.stamp_ns for each in bag.messages()]
        assert {each.topic for each in bag.messages(['/true_pose'])} == {'/true_pose'}
    assert stamps == sorted(stamps)
    assert len(stamps) == 81


@pytest.mark.parametrize('fraction', [0.0, 0.001, 0.3, 0.7, 0.99])
@pytest.mark.parametrize('kind', ['mcap', 'sqlite'])
def test_a_truncated_file_is_refused(bag_path, tmp_path, kind, fraction):
    path = bag_path if kind == 'mcap' else write_sqlite_bag(tmp_path / 'bag')
    file = path / (MCAP if kind == 'mcap' else 'bag.db3')
    data = file.read_bytes()
    file.write_bytes(data[: int(len(data) * fraction)])
    assert 'record it again' in refusal(path)


@pytest.mark.parametrize(
    ('name', 'text', 'hint'),
    [
        ('none', None, 'does not exist'),
        ('', None, 'metadata.yaml'),
        ('old.bag', 'something', 'rosbags-convert'),
        ('notes.txt', 'something', 'not a rosbag2'),
        ('a.mcap', '', 'is empty'),
        ('a.mcap', 'rosbag2_bagfile_information: 1', 'cannot be read'),
    ],
)
def test_what_is_no_bag_is_refused(tmp_path, name, text, hint):
    if text is not None:
        (tmp_path / name).write_text(text)
    assert hint in refusal(tmp_path / name)


def test_a_bag_that_contradicts_its_metadata_is_refused(bag_path):
    metadata = bag_path / 'metadata.yaml'
    text = metadata.read_text()
    metadata.write_text(text.replace('message_count: 41', 'message_count: 45'))
    assert 'has 81 of the 85 messages' in refusal(bag_path)
    metadata.write_text('rosbag2_bagfile_information: {version: [')
    assert 'cannot be read' in refusal(bag_path)
    metadata.write_text(text)
    (bag_path / MCAP).unlink()
    assert MCAP in refusal(bag_path)
