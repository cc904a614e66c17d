import numpy as np
from taught_wall import HERE, RIG, seen

from stereo_landmark.core.pair.camera_calibration import PairFault, pair_fault


def test_a_good_pair_has_no_fault():
    assert pair_fault(*seen(HERE), RIG) is None


def test_row_differences_of_some_pixels_are_detected():
    left, right = seen(HERE)
    assert pair_fault(left, np.roll(right, 3, axis=0), RIG) is PairFault.NOT_RECTIFIED
    assert pair_fault(left, np.roll(right, -4, axis=0), RIG) is PairFault.NOT_RECTIFIED


def test_swapped_images_are_detected():
    assert pair_fault(*seen(HERE)[::-1], RIG) is PairFault.SWAPPED


def test_where_there_is_nothing_to_see_nothing_is_said():
    blank = np.full((240, 376), 90, np.uint8)
    assert pair_fault(blank, blank, RIG) is None
    assert pair_fault(blank, seen(HERE)[1], RIG) is None
    noise = np.random.default_rng(1).integers(0, 256, (2, 240, 376), dtype=np.uint8)
    assert pair_fault(*noise, RIG) is None
