from types import SimpleNamespace

import pytest

from shirube_bags.errors import BagError
from stereo_landmark.files.camera_files import choose_topics

IMAGE, INFO, IMU = 'sensor_msgs/msg/CompressedImage', 'sensor_msgs/msg/CameraInfo', 'sensor_msgs/msg/Imu'


class Bag:
    """A fake bag that has only topic names."""

    path = 'bag'

    def __init__(self, *names):
        kinds = {'compressed': IMAGE, 'camera_info': INFO, 'imu': IMU}
        self.topics = {
            name: SimpleNamespace(name=name, msgtype=kinds[name.rpartition('/')[2]]) for name in names
        }


BOTH = [
    f'/{side}/{name}'
    for side in ('left', 'right')
    for name in ('image_raw/compressed', 'image_rect/compressed', 'camera_info')
]


@pytest.mark.parametrize(('is_raw', 'name'), [(False, 'image_rect'), (True, 'image_raw')])
def test_of_raw_and_rectified_images_those_are_taken_that_are_wanted(is_raw, name):
    topics = choose_topics(Bag(*BOTH, '/imu'), {}, is_raw=is_raw)
    assert topics.images == (f'/left/{name}/compressed', f'/right/{name}/compressed')
    assert topics.camera_infos == ('/left/camera_info', '/right/camera_info')
    assert topics.imu == '/imu'


def test_without_an_imu_there_is_none():
    assert choose_topics(Bag(*BOTH), {}, is_raw=False).imu == ''


def test_ambiguous_topics_must_be_named():
    bag = Bag('/front/a/compressed', '/front/b/compressed', '/front/a/camera_info', '/front/b/camera_info')
    with pytest.raises(BagError, match='several topics of type Image; name one of /front/a/compressed'):
        choose_topics(bag, {}, is_raw=False)
