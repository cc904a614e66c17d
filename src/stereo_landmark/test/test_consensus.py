from dataclasses import replace

import numpy as np
from place_scenes import RIG, errors_of, panel, random_state, teach, view

from stereo_landmark.core.place.place_locator import NoPlaceFix, NoPlaceFixReason, PlaceLocator
from stereo_landmark.core.place.point_registration import consistent_points, find_consensus_set

NOISE = 0.1
NEXT_ROW = np.array([0.0, 0.0, 0.03])
"""Spacing of the repetitive pattern [m]."""


def mismatched_points(count, seed, step=NEXT_ROW):
    """Return measured points, taught points and the state; some points are mismatched to the next row."""
    rng = np.random.default_rng(seed)
    points, state = panel(depth=0.3, seed=seed), random_state(rng)
    wrong = rng.choice(len(points), count, replace=False)
    moved = points.copy()
    moved[wrong] += step
    return view(moved, state, NOISE, rng), teach(points, NOISE, rng), state, wrong


def inliers_of(seen, taught):
    """Return the inliers of the vote and those of the distances."""
    found = PlaceLocator(RIG).spatial_points(seen)
    return find_consensus_set(found, taught, 0.0).inliers, consistent_points(found, taught)


def test_all_points_of_one_displacement_agree():
    for seed in range(20):
        seen, taught, _, _ = mismatched_points(0, seed)
        assert np.all(inliers_of(seen, taught))


def test_a_family_that_was_taken_for_its_neighbours_is_outvoted_and_the_fix_is_right():
    for seed in range(20):
        seen, taught, state, wrong = mismatched_points(5, seed, 4.0 * NEXT_ROW)
        inliers, _ = inliers_of(seen, taught)
        assert not inliers[wrong].any()
        assert inliers.sum() == 11
        fix = PlaceLocator(RIG).locate(seen, taught)
        assert np.linalg.norm(errors_of(fix.T_place_base, fix.height, state)[:3]) < 0.03
        assert len(fix.names) >= 10


def test_a_near_family_is_seen_by_the_vote_but_not_by_the_distances():
    """Distances between two adjacent groups change little."""
    kept = np.zeros(2, int)
    for seed in range(20):
        seen, taught, _, wrong = mismatched_points(5, seed)
        kept += [inliers[wrong].sum() for inliers in inliers_of(seen, taught)]
    assert kept[0] < 0.5 * kept[1]


def test_two_groups_with_equal_support_are_ambiguous():
    for seed in range(10):
        seen, taught, _, _ = mismatched_points(8, seed, 4.0 * NEXT_ROW)
        fix = PlaceLocator(RIG).locate(seen, taught)
        assert isinstance(fix, NoPlaceFix)
        assert fix.reason is NoPlaceFixReason.INCONSISTENT


def test_points_on_one_vertical_line_determine_no_yaw():
    points = np.array([[3.0, 0.1, 0.2 * i] for i in range(4)])
    found = PlaceLocator(RIG).spatial_points(view(points, np.zeros(6)))
    vote = find_consensus_set(found, teach(points), 0.0)
    assert not vote.inliers.any()
    assert vote.support == 0.0


def test_what_both_images_show_in_different_rows_is_left_out():
    points = panel()
    seen = view(points, np.zeros(6), NOISE, np.random.default_rng(1))
    pixels = seen.pixels.copy()
    pixels[:2, 3] += 3.0
    fix = PlaceLocator(RIG).locate(replace(seen, pixels=pixels), teach(points))
    assert {'point 0', 'point 1'}.isdisjoint(fix.names)
    assert len(fix.names) == 14
    pixels[:, 3] = seen.pixels[:, 3] + 3.0
    answer = PlaceLocator(RIG).locate(replace(seen, pixels=pixels), teach(points))
    assert answer.detail.startswith('0 of 16 points are in the same row of both images; ')


def test_points_elsewhere_are_left_out_and_only_they():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        wrong = rng.choice(16, 5, replace=False)
        points = panel()
        points[wrong] += rng.choice([-1.0, 1.0], (5, 3)) * [0.3, 0.15, 0.12]
        seen = view(points, random_state(rng), NOISE, rng)
        _, kept = inliers_of(seen, teach(panel(), NOISE, rng))
        assert not kept[wrong].any()
        assert kept.sum() == 11


def test_two_inconsistent_points_are_both_rejected():
    points, rng = panel(count=2), np.random.default_rng(1)
    seen = view(points + np.diag([0.0, 0.3, 0.0])[:2], np.zeros(6), NOISE, rng)
    found, taught = PlaceLocator(RIG).spatial_points(seen), teach(points, NOISE, rng)
    assert not consistent_points(found, taught).any()
