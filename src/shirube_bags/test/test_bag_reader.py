"""Bags are read completely and in order; invalid ones are rejected in one line with a remedy."""

import shutil

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


def test_topics_and_times_are_known(bag_path):
    with BagReader(bag_path) as bag:
        counts = {name: topic.message_count for name, topic in bag.topics.items()}
        assert counts == {'/image_raw': 41, '/true_pose': 40}
        assert bag.message_count == 81
        assert bag.end_ns - bag.start_ns == 800_000_000


def test_messages_come_in_the_order_of_their_stamps(bag_path):
    with BagReader(bag_path) as bag:
        stamps = [each.stamp_ns for each in bag.messages()]
    assert stamps == sorted(stamps)
    assert len(stamps) == 81


def test_only_wanted_topics_are_read(bag_path):
    with BagReader(bag_path) as bag:
        assert {each.topic for each in bag.messages(['/true_pose'])} == {'/true_pose'}


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


@pytest.mark.parametrize('fraction', [0.0, 0.001, 0.3, 0.7, 0.99])
def test_a_truncated_mcap_is_refused(bag_path, fraction):
    data = (bag_path / MCAP).read_bytes()
    (bag_path / MCAP).write_bytes(data[: int(len(data) * fraction)])
    line = refusal(bag_path)
    assert 'record it again' in line


@pytest.mark.parametrize('fraction', [0.0, 0.3, 0.9])
def test_a_truncated_sqlite_file_is_refused(tmp_path, fraction):
    path = write_sqlite_bag(tmp_path / 'bag')
    data = (path / 'bag.db3').read_bytes()
    (path / 'bag.db3').write_bytes(data[: int(len(data) * fraction)])
    assert 'truncated or corrupted' in refusal(path)


def test_flipped_bytes_are_refused(bag_path):
    data = bytearray((bag_path / MCAP).read_bytes())
    for index in range(200, len(data) // 2, 50):
        data[index] ^= 0xFF
    (bag_path / MCAP).write_bytes(data)
    assert 'truncated or corrupted' in refusal(bag_path)


def test_fewer_messages_than_promised_are_noticed(bag_path):
    metadata = bag_path / 'metadata.yaml'
    metadata.write_text(metadata.read_text().replace('message_count: 41', 'message_count: 45'))
    assert 'has 81 of the 85 messages' in refusal(bag_path)


def test_broken_metadata_is_refused(bag_path):
    (bag_path / 'metadata.yaml').write_text('rosbag2_bagfile_information: {version: [')
    assert 'cannot be read' in refusal(bag_path)


def test_a_missing_file_of_the_bag_is_refused(bag_path):
    (bag_path / MCAP).unlink()
    assert MCAP in refusal(bag_path)


def test_a_missing_bag_is_refused(tmp_path):
    assert 'does not exist' in refusal(tmp_path / 'none')


def test_a_folder_without_metadata_is_refused(tmp_path):
    assert 'metadata.yaml' in refusal(tmp_path)


@pytest.mark.parametrize(('name', 'hint'), [('old.bag', 'rosbags-convert'), ('notes.txt', 'not a rosbag2')])
def test_files_of_other_types_are_refused(tmp_path, name, hint):
    (tmp_path / name).write_text('something')
    assert hint in refusal(tmp_path / name)


def test_an_empty_file_is_refused(tmp_path):
    (tmp_path / 'a.mcap').touch()
    assert 'is empty' in refusal(tmp_path / 'a.mcap')


def test_text_behind_the_name_of_a_bag_is_refused(tmp_path, bag_path):
    shutil.copy(bag_path / 'metadata.yaml', tmp_path / 'text.mcap')
    assert 'cannot be read' in refusal(tmp_path / 'text.mcap')


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
