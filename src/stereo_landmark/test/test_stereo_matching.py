import numpy as np
import pytest

from stereo_landmark.core.procedure.stereo_matching import candidate_pairs
from stereo_landmark.core.procedure.stereo_view import match_pairs

ANY = (0.0, 300.0)


def matched(left, right, disparities=ANY):
    """Return the match of each point of the left image, all of which look the same."""
    shapes = np.zeros((len(left), 1)), np.zeros((len(right), 1))
    pairs = candidate_pairs(left, shapes[0], right, shapes[1], disparities)
    seen = left[pairs[:, 0], 0] - right[pairs[:, 1], 0]
    return dict(match_pairs([left], [pairs], [seen], [1.0], 0).tolist())


def row(count, disparity, pitch=70.0, v=100.0):
    left = np.column_stack([200.0 + pitch * np.arange(count), np.full(count, v)])
    return left, left - [disparity, 0.0]


@pytest.mark.parametrize('disparity', [20.0, 47.0, 70.0, 105.0])
@pytest.mark.parametrize('count', [2, 5, 9])
def test_identical_things_in_a_row_are_not_taken_for_their_neighbours(count, disparity):
    left, right = row(count, disparity)
    assert matched(left, right) == {i: i for i in range(count)}


def test_one_that_only_one_camera_sees_stays_alone():
    left, right = row(5, 70.0)
    assert matched(left, right[[0, 1, 3, 4]]) == {0: 0, 1: 1, 3: 2, 4: 3}


@pytest.mark.parametrize('others', [[0, 1, 2, 3], [1, 2, 3, 4]])
def test_a_row_of_which_one_end_is_hidden_is_not_guessed(others):
    left, right = row(5, 70.0)
    assert matched(left, right[others], (0.0, 140.0)) == {}


def test_a_slanted_wall_is_matched():
    left, right = row(6, 60.0)
    right[:, 0] -= 0.1 * (left[:, 0] - 200.0)
    assert matched(left, right) == {i: i for i in range(6)}


def test_what_was_detected_twice_is_no_rival_of_itself():
    left, right = row(4, 60.0)
    left, right = np.repeat(left, 2, axis=0), np.repeat(right, 2, axis=0)
    left[1::2] += 0.5
    partners = matched(left, right)
    assert {i: j // 2 for i, j in partners.items()} == {i: i // 2 for i in range(8)}


def test_rows_shapes_and_depths_part_what_looks_the_same():
    (left, right), same = row(3, 50.0), np.zeros((3, 1))
    assert len(candidate_pairs(left, same, right + np.array([0.0, 5.0]), same, ANY)) == 0
    assert len(candidate_pairs(left, same, right, np.ones((3, 1)), ANY)) == 0
    assert len(candidate_pairs(left[:0], same[:0], right, same, ANY)) == 0
    only = candidate_pairs(left, same, right, same, (40.0, 60.0))
    assert only.tolist() == [[0, 0], [1, 1], [2, 2]]
