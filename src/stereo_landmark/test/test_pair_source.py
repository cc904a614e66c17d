"""Pairs of a bag have equal stamps; long bags are subsampled."""

import numpy as np
import pytest
from pair_bag import write_pairs
from place_scenes import MOUNT
from taught_wall import CALIBRATIONS, HERE, RAW, RIG, TAUGHT, raw_pair, seen

from stereo_landmark.commands.teach import make_parser
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.page import pair_source as module
from stereo_landmark.page.pair_source import bag_pairs

SECOND = 1_000_000_000
INSIDE = np.s_[30:-30, 40:-40]


@pytest.fixture
def offered(tmp_path):
    """Write a bag, and return the pairs that are offered."""

    def write(pairs, *options, calibrations=CALIBRATIONS, tilt=None):
        bag = write_pairs(tmp_path / f'bag_{len(list(tmp_path.iterdir()))}', pairs, calibrations, tilt)
        return bag_pairs(make_parser().parse_args(['--bag', str(bag), *options]), MOUNT)

    return write


def test_all_pairs_of_a_short_drive_are_offered_by_their_time(offered):
    states = (TAUGHT, HERE)
    pairs = offered([(5 * SECOND + number * SECOND // 2, seen(state)) for number, state in enumerate(states)])
    assert pairs.rig == RIG
    assert list(pairs.labels) == ['0.0 s', '0.5 s']
    for number, state in enumerate(states):
        assert np.abs(np.subtract(pairs.images(number).left, seen(state)[0], dtype=float)).mean() < 2.0


def test_of_a_long_drive_pairs_are_offered_evenly(offered, monkeypatch):
    monkeypatch.setattr(module, 'PAIRS_MAX', 3)
    labels = offered([(t * SECOND, seen(TAUGHT)) for t in range(1, 9)]).labels
    assert list(labels) == ['0.0 s', '3.0 s', '6.0 s']


def test_raw_images_are_rectified(offered):
    pair = offered([(SECOND, raw_pair(TAUGHT))], '--rectify', calibrations=RAW).images(0)
    assert np.abs(np.subtract(pair.left, seen(TAUGHT)[0], dtype=float))[INSIDE].mean() < 4.0


def test_swapped_cameras_and_unequal_stamps_are_reported(offered):
    with pytest.raises(StereoLandmarkError, match='left and right are swapped'):
        offered([(SECOND, seen(TAUGHT)[::-1])]).images(0)
    apart = [(SECOND, seen(TAUGHT), 5_000_000)]
    with pytest.raises(StereoLandmarkError, match='no common stamps; give --approximate-sync'):
        offered(apart)
    assert len(offered(apart, '--approximate-sync', '0.01').labels) == 1


def test_each_pair_has_the_tilt_of_its_moment(offered):
    """Also for a long bag with more imu messages than the tilt buffer holds."""
    entries = [(t * SECOND, seen(TAUGHT)) for t in (1, 2, 3)]
    pairs = offered(entries, '--tilt', '0.5', '0.5', tilt=(0.03, -0.02))
    for number in range(3):
        assert pairs.images(number).tilt == pytest.approx((0.03, -0.02))
    assert offered(entries, '--tilt', '0.01', '0.02').images(0).tilt == (0.01, 0.02)
