"""Bags of other recorders: every version of rosbag2's metadata, both storages, compressed, split, with services."""

import pytest
import yaml
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from shirube_bags.bag_reader import BagReader, jazzy_types
from shirube_bags.errors import BagError, ReplayError
from shirube_bags.ros_session import load_message_class

COMPRESSION = {'none': None, 'file': CompressionMode.FILE, 'message': CompressionMode.MESSAGE}
# The key of rosbag2's metadata that a version has brought.
SINCE = {'files': 5, 'custom_data': 6, 'ros_distro': 8}


def write_talker(path, storage='mcap', compression='none', first=0):
    types = jazzy_types()
    bag = Writer(path, version=9, storage_plugin=StoragePlugin[storage.upper()])
    if COMPRESSION[compression]:
        bag.set_compression(COMPRESSION[compression], CompressionFormat.ZSTD)
    with bag:
        topic = bag.add_connection('/topic', 'std_msgs/msg/String', typestore=types)
        for stamp in range(first, first + 10):
            text = types.types['std_msgs/msg/String'](f'Hello World: {stamp}')
            bag.write(topic, stamp, types.serialize_cdr(text, 'std_msgs/msg/String'))
    return path


def edit_metadata(path, edit):
    file = path / 'metadata.yaml'
    content = yaml.safe_load(file.read_text())
    edit(content['rosbag2_bagfile_information'])
    file.write_text(yaml.safe_dump(content))


def texts(path):
    with BagReader(path) as bag:
        return [bag.decode(each).data for each in bag.messages()]


def as_version(version):
    """Return the edit that writes the metadata as a rosbag2 of that version did."""
    time = {'sec': 0, 'nsec': 0}
    # rosbag2's examples have another QoS in metadata.yaml than in the file: it came with version 4.
    profile = {
        'history': 3,
        'depth': 0,
        'reliability': 1,
        'durability': 2,
        'liveliness': 1,
        'deadline': time,
        'lifespan': {'sec': 10, 'nsec': 0},
        'liveliness_lease_duration': time,
        'avoid_ros_namespace_conventions': False,
    }

    def edit(content):
        content['version'] = version
        for key, since in SINCE.items():
            if version < since:
                content.pop(key, None)
        for topic in content['topics_with_message_count']:
            data = topic['topic_metadata']
            profiles = [profile] if version >= 9 else yaml.safe_dump([profile])
            data.update(offered_qos_profiles=profiles, type_description_hash='')
            if version < 7:
                del data['type_description_hash']
            if version < 4:
                del data['offered_qos_profiles']
        if version < 3:
            del content['compression_mode'], content['compression_format']

    return edit


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
@pytest.mark.parametrize('version', range(1, 10))
def test_every_version_of_the_metadata_is_read(tmp_path, version, storage):
    path = write_talker(tmp_path / 'talker', storage)
    edit_metadata(path, as_version(version))
    assert texts(path) == [f'Hello World: {stamp}' for stamp in range(10)]


@pytest.mark.parametrize(
    ('storage', 'compression'), [('mcap', 'file'), ('sqlite3', 'file'), ('mcap', 'message'), ('sqlite3', 'message')]
)
def test_compressed_bags_are_read(tmp_path, storage, compression):
    path = write_talker(tmp_path / 'talker', storage, compression)
    edit_metadata(path, as_version(4))
    assert texts(path) == [f'Hello World: {stamp}' for stamp in range(10)]


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_split_bags_are_read_in_order(tmp_path, storage):
    path, second = write_talker(tmp_path / 'a', storage), write_talker(tmp_path / 'b', storage, first=10)
    (file,) = second.glob('b.*')
    file.rename(path / file.name)

    def edit(content):
        content['relative_file_paths'].append(file.name)
        content['message_count'] = content['topics_with_message_count'][0]['message_count'] = 20
        content['duration']['nanoseconds'] = 19

    edit_metadata(path, edit)
    assert texts(path) == [f'Hello World: {stamp}' for stamp in range(20)]


@pytest.mark.parametrize(
    'edit',
    [{'version': 10}, {'storage_identifier': 'my_storage'}, {'compression_mode': 'FILE', 'compression_format': 'lz4'}],
)
def test_what_another_recorder_must_convert_is_no_damage(tmp_path, edit):
    path = write_talker(tmp_path / 'talker')
    edit_metadata(path, lambda content: content.update(edit))
    with pytest.raises(BagError, match='ros2 bag convert'):
        texts(path)


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_events_of_services_do_not_hide_the_other_topics(tmp_path, storage):
    path = tmp_path / 'bag'
    events = 'std_srvs/srv/Trigger_Event'
    types = jazzy_types()
    with Writer(path, version=9, storage_plugin=StoragePlugin[storage.upper()]) as bag:
        text = bag.add_connection('/topic', 'std_msgs/msg/String', typestore=types)
        # rosbag2 writes the service's definition, which is no message.
        definition = '---\nbool success\nstring message\n'
        service = bag.add_connection('/save/_service_event', events, msgdef=definition, rihs01='RIHS01_00')
        bag.write(text, 1, b'\0\1\0\0\2\0\0\0a\0')
        bag.write(service, 2, b'\0\1\0\0\1')
    with BagReader(path) as reader:
        first, second = reader.messages()
        assert reader.decode(first).data == 'a'
        assert second.topic == '/save/_service_event'
        with pytest.raises(BagError, match=f'{events} of /save/_service_event is not known'):
            reader.decode(second)


def test_events_of_services_are_published_and_parts_of_actions_are_named():
    assert load_message_class('std_srvs/srv/Trigger_Event').__name__ == 'Trigger_Event'
    for msgtype in ('std_srvs/srv/Trigger', 'my_msgs/action/Go_FeedbackMessage', 'nonsense', ''):
        with pytest.raises(ReplayError, match='neither a message nor'):
            load_message_class(msgtype)
