import numpy as np
from place_scenes import RIG, panel, random_state, teach, view

from stereo_landmark.core.place.consensus import consistent_points
from stereo_landmark.core.place.place_locator import PlaceLocator


def measured(points, state, seed, noise=0.1):
    rng = np.random.default_rng(seed)
    return PlaceLocator(RIG).spatial_points(view(points, state, noise, rng)), teach(panel(), noise, rng)


def test_points_that_only_moved_together_are_consistent():
    for seed in range(20):
        found, taught = measured(panel(), random_state(np.random.default_rng(seed)), seed)
        assert consistent_points(found, taught).all()


def test_points_elsewhere_are_left_out_and_only_they():
    for seed in range(20):
        points = panel()
        wrong = np.random.default_rng(seed).choice(16, 5, replace=False)
        points[wrong] += np.random.default_rng(seed).choice([-1.0, 1.0], (5, 3)) * [0.3, 0.15, 0.12]
        found, taught = measured(points, random_state(np.random.default_rng(seed)), seed)
        kept = consistent_points(found, taught)
        assert not kept[wrong].any()
        assert kept.sum() == 11


def test_two_inconsistent_points_are_both_rejected():
    points = panel(count=2)
    found, taught = measured(points + np.array([[0.0, 0.0, 0.0], [0.0, 0.3, 0.0]]), np.zeros(6), 1)
    assert not consistent_points(found, taught.select(found.names)).any()
