import numpy as np
import pytest

from stereo_landmark.core.pair.pair_stream import StampSynchronizer
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

MILLISECOND = 1_000_000


def run(pairing, *arrivals):
    """Return the pairs of stamps for arrivals of (side, stamp [ms])."""
    pairs = (pairing.add(side, stamp * MILLISECOND, stamp) for side, stamp in arrivals)
    return [pair for pair in pairs if pair is not None]


def test_equal_stamps_make_pairs_left_first_whatever_comes_first():
    arrivals = [(0, 0), (1, 0), (1, 50), (0, 50), (0, 100), (0, 150), (1, 100), (1, 150)]
    assert run(StampSynchronizer(0, 5), *arrivals) == [(0, 0), (50, 50), (100, 100), (150, 150)]


def test_nearly_equal_stamps_pair_only_within_the_tolerance():
    arrivals = [(0, 0), (1, 4), (0, 50), (1, 57), (1, 104), (0, 100)]
    assert run(StampSynchronizer(5 * MILLISECOND, 5), *arrivals) == [(0, 4), (100, 104)]
    assert run(StampSynchronizer(0, 9), *arrivals) == []


def test_the_nearest_of_several_is_the_partner():
    assert run(StampSynchronizer(20 * MILLISECOND, 5), (0, 0), (0, 10), (0, 25), (1, 12)) == [(10, 12)]


def test_every_image_is_in_one_pair_at_most_though_some_are_lost():
    rng = np.random.default_rng(5)
    arrivals = sorted(
        (stamp + rng.integers(0, 120), side, stamp)
        for stamp in range(0, 3000, 50)
        for side in (0, 1)
        if rng.random() > 0.2
    )
    by_side = [sorted(s for _, side, s in arrivals if side == k) for k in (0, 1)]
    order = {k: iter(by_side[k]) for k in (0, 1)}
    pairs = run(StampSynchronizer(0, 20), *((side, next(order[side])) for _, side, _ in arrivals))
    assert pairs == [(s, s) for s in by_side[0] if s in by_side[1]]


def test_inputs_without_common_stamps_are_reported():
    arrivals = ((side, 100 * k + 7 * side) for k in range(5) for side in (0, 1))
    with pytest.raises(StereoLandmarkError, match=r'no stamps in common; .*approximate_sync'):
        run(StampSynchronizer(0, 3), *arrivals)


def test_a_camera_without_images_is_reported():
    with pytest.raises(StereoLandmarkError, match='right images are received, but no left images'):
        run(StampSynchronizer(0, 3), *((1, 100 * k) for k in range(5)))
