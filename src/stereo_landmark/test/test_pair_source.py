"""Pairs of a bag have equal stamps; long bags are subsampled."""

import numpy as np
import pytest
from pair_bag import write_pairs
from place_scenes import MOUNT
from taught_wall import CALIBRATIONS, HERE, RAW, RIG, TAUGHT, raw_image, seen

from stereo_landmark.commands.teach import make_parser
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.page import pair_source as module
from stereo_landmark.page.pair_source import bag_pairs

SECOND = 1_000_000_000


def offered(path, *options):
    return bag_pairs(make_parser().parse_args(['--bag', str(path), *options]), MOUNT)


def test_all_pairs_of_a_short_drive_are_offered_by_their_time(tmp_path):
    stamps = (5 * SECOND, 5 * SECOND + SECOND // 2)
    write_pairs(
        tmp_path / 'bag', [(t, t, *seen(state)) for t, state in zip(stamps, (TAUGHT, HERE))], CALIBRATIONS
    )
    pairs = offered(tmp_path / 'bag')
    assert pairs.rig == RIG
    assert list(pairs.labels) == ['0.0 s', '0.5 s']
    for number, state in enumerate((TAUGHT, HERE)):
        difference = pairs.images(number).left.astype(float) - seen(state)[0]
        assert np.abs(difference).mean() < 2.0


def test_of_a_long_drive_pairs_are_offered_evenly(tmp_path, monkeypatch):
    monkeypatch.setattr(module, 'PAIRS_MAX', 3)
    images = seen(TAUGHT)
    write_pairs(tmp_path / 'bag', [(t * SECOND, t * SECOND, *images) for t in range(1, 9)], CALIBRATIONS)
    assert list(offered(tmp_path / 'bag').labels) == ['0.0 s', '3.0 s', '6.0 s']


def test_raw_images_are_rectified(tmp_path):
    raw = [raw_image(image, calibration) for image, calibration in zip(seen(TAUGHT), RAW)]
    write_pairs(tmp_path / 'bag', [(SECOND, SECOND, *raw)], RAW)
    pair = offered(tmp_path / 'bag', '--rectify').images(0)
    inside = np.s_[30:-30, 40:-40]
    assert np.abs(pair.left[inside].astype(float) - seen(TAUGHT)[0][inside]).mean() < 4.0


def test_swapped_cameras_and_unequal_stamps_are_reported(tmp_path):
    left, right = seen(TAUGHT)
    write_pairs(tmp_path / 'swapped', [(SECOND, SECOND, right, left)], CALIBRATIONS)
    with pytest.raises(StereoLandmarkError, match='left and right are swapped'):
        offered(tmp_path / 'swapped').images(0)
    write_pairs(tmp_path / 'apart', [(SECOND, SECOND + 5_000_000, left, right)], CALIBRATIONS)
    with pytest.raises(StereoLandmarkError, match='no common stamps; give --approximate-sync'):
        offered(tmp_path / 'apart')
    assert len(offered(tmp_path / 'apart', '--approximate-sync', '0.01').labels) == 1


def test_each_pair_has_the_tilt_of_its_moment(tmp_path):
    """Also for a long bag with more imu messages than the tilt buffer holds."""
    entries = [(t * SECOND, t * SECOND, *seen(TAUGHT)) for t in (1, 2, 3)]
    write_pairs(tmp_path / 'bag', entries, CALIBRATIONS, (0.03, -0.02))
    pairs = offered(tmp_path / 'bag', '--tilt', '0.5', '0.5')
    for number in range(3):
        assert pairs.images(number).tilt == pytest.approx((0.03, -0.02))
    write_pairs(tmp_path / 'without', entries, CALIBRATIONS)
    assert offered(tmp_path / 'without', '--tilt', '0.01', '0.02').images(0).tilt == (0.01, 0.02)
