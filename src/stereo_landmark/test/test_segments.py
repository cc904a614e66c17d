import math

import numpy as np
import pytest
from seen_shapes import SIZE, ellipse_photo, polygon_photo, segments_of, turned_rectangle

from scene_simulator.imaging.antialiased_shapes import coverage, photograph, polygon_intervals


def test_a_disc_is_one_closed_segment_with_the_bright_side_to_the_right():
    segments = segments_of(ellipse_photo((50, 45), (25.0, 25.0), 0.0))
    assert len(segments) == 1
    assert segments.closed[0]
    steps = np.diff(segments.segment_points(0), axis=0)
    right = np.column_stack([-steps[:, 1], steps[:, 0]])
    assert (np.sum(right * segments.gradients[:-1], axis=1) > 0.0).all()
    assert segments.lengths[0] == pytest.approx(2 * math.pi * 25.0, rel=0.03)
    assert segments.chords[0] < 2.5


def test_each_point_of_a_segment_follows_the_one_before():
    segments = segments_of(polygon_photo(turned_rectangle((50, 45), 50.0, 30.0, 0.5), noise=4.0))
    for k in range(len(segments)):
        assert np.abs(np.diff(np.rint(segments.segment_points(k)), axis=0)).max() <= 2


def test_chain_code_walks_from_the_first_pixel_to_the_last():
    segments = segments_of(ellipse_photo((50, 45), (25.0, 15.0), 0.3))
    steps = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]])
    pixels = np.rint(segments.segment_points(0))
    np.testing.assert_array_equal(steps[segments.segment_chain_code(0)].sum(axis=0), pixels[-1] - pixels[0])


def test_polyline_of_a_square_bends_at_its_corners_and_stays_near_the_points():
    corners = turned_rectangle((50, 45), 40.0, 40.0, 0.2)
    segments = segments_of(polygon_photo(corners))
    vertices = np.concatenate([segments.segment_polyline(k) for k in range(len(segments))])
    for corner in corners:
        assert np.hypot(*(vertices - corner).T).min() < 2.5
    assert len(vertices) < 14


def test_noise_and_weak_lines_are_removed_by_length_and_threshold():
    image = polygon_photo(turned_rectangle((50, 45), 40.0, 20.0, 0.2), contrast=-30.0)
    assert len(segments_of(image)) >= 1
    assert len(segments_of(image, threshold=40.0)) == 0
    assert len(segments_of(image, length_min=500.0)) == 0


def test_a_line_that_ends_at_another_is_its_neighbour():
    light = 60.0 + 60.0 * coverage(polygon_intervals([[50, -9], [109, -9], [109, 99], [50, 99]]), SIZE, 0.7)
    light += 60.0 * coverage(polygon_intervals([[50, 45], [109, 45], [109, 99], [50, 99]]), SIZE, 0.7)
    segments = segments_of(photograph(light, 1.0))
    assert len(segments) >= 2
    neighbours = segments.neighbours
    assert any(neighbours)
    for k, others in enumerate(neighbours):
        assert k not in others
        assert all(k in neighbours[other] for other in others)


def test_nothing_is_lost_in_an_empty_image():
    segments = segments_of(np.full((40, 50), 90, np.uint8))
    assert len(segments) == 0
    assert segments.neighbours == []
    assert segments.lengths.shape == segments.chords.shape == (0,)
