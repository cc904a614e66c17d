from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from pair_bag import IMAGE, INFO, info_of
from stereo_calibrations import write_calibration
from taught_wall import RAW, SIDES

from shirube_bags.errors import BagError
from shirube_ros.errors import CalibrationError, CameraInfoError
from stereo_landmark.files.camera_files import calibration_from_camera_info, choose_topics, load_camera_calibration

KINDS = {'compressed': IMAGE, 'camera_info': INFO, 'imu': 'sensor_msgs/msg/Imu'}
NAMES = ('image_raw/compressed', 'image_rect/compressed', 'camera_info')
BOTH = [f'/{side}/{name}' for side in SIDES for name in NAMES]


def bag_of(*names):
    """Return a fake bag that has only topics."""
    kinds = {name: KINDS[name.rpartition('/')[2]] for name in names}
    topics = {name: SimpleNamespace(name=name, msgtype=kind) for name, kind in kinds.items()}
    return SimpleNamespace(path='bag', topics=topics)


@pytest.mark.parametrize(('is_raw', 'name'), [(False, 'image_rect'), (True, 'image_raw')])
def test_of_raw_and_rectified_images_those_are_taken_that_are_wanted(is_raw, name):
    topics = choose_topics(bag_of(*BOTH, '/imu'), {}, is_raw=is_raw)
    assert topics.images == (f'/left/{name}/compressed', f'/right/{name}/compressed')
    assert topics.camera_infos == ('/left/camera_info', '/right/camera_info')
    assert topics.imu == '/imu'
    assert choose_topics(bag_of(*BOTH), {}, is_raw=False).imu == ''


def test_ambiguous_topics_must_be_named():
    bag = bag_of('/front/a/compressed', '/front/b/compressed', '/front/a/camera_info', '/front/b/camera_info')
    with pytest.raises(BagError, match='several topics of type Image; name one of /front/a/compressed'):
        choose_topics(bag, {}, is_raw=False)


def test_files_and_messages_give_the_same_calibration(tmp_path):
    assert load_camera_calibration(write_calibration(tmp_path / 'right.yaml', RAW[1])) == RAW[1]
    assert calibration_from_camera_info(info_of(RAW[1]), 'right/camera_info') == RAW[1]


@pytest.mark.parametrize(
    ('change', 'words'), [({'p': np.zeros(12)}, ' is not rectified'), ({'k': np.zeros(9)}, ' is not calibrated')]
)
def test_messages_of_cameras_that_are_not_calibrated_as_a_pair_are_refused(change, words):
    with pytest.raises(CameraInfoError, match=f'right/camera_info{words}'):
        calibration_from_camera_info(replace(info_of(RAW[1]), **change), 'right/camera_info')


@pytest.mark.parametrize(
    ('missing', 'words'), [('projection_matrix', ' is not rectified'), ('camera_matrix', ': camera_matrix')]
)
def test_files_without_rectification_are_refused(tmp_path, missing, words):
    path = write_calibration(tmp_path / 'left.yaml', RAW[0])
    path.write_text(path.read_text().replace(missing, 'matrix'))
    with pytest.raises(CalibrationError, match=rf'left\.yaml{words}'):
        load_camera_calibration(path)
