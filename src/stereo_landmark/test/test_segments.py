import numpy as np
import pytest
from seen_shapes import ellipse_photo, polygon_photo, segments_of, turned_rectangle

from stereo_landmark.core.edges.edges import extract_edges
from stereo_landmark.core.edges.linking import extract_chains, link_points, polyline_vertices
from stereo_landmark.core.settings import EdgeSettings


def test_a_disc_is_one_closed_segment_with_the_bright_side_to_the_right():
    segments = segments_of(ellipse_photo((50, 45), (25.0, 25.0), 0.0))
    assert len(segments) == 1
    assert segments.closed[0]
    steps = np.diff(segments.points, axis=0)
    right = np.column_stack([-steps[:, 1], steps[:, 0]])
    assert (np.sum(right * segments.gradients[:-1], axis=1) > 0.0).all()


def test_each_point_of_a_segment_follows_the_one_before():
    segments = segments_of(polygon_photo(turned_rectangle((50, 45), 50.0, 30.0, 0.5), noise=4.0))
    for k in range(len(segments)):
        points = segments.points[segments.starts[k] : segments.starts[k + 1]]
        assert np.abs(np.diff(np.rint(points), axis=0)).max() <= 2


@pytest.mark.parametrize('tolerance', [0.5, 2.0])
def test_the_chords_of_a_polyline_stay_within_the_tolerance(tolerance):
    segments = segments_of(ellipse_photo((50, 45), (30.0, 25.0), 0.0, noise=0.5), bend_tolerance=tolerance)
    vertices = segments.vertex_indices[segments.vertex_starts[0] : segments.vertex_starts[1]]
    distances = []
    for begin, end in zip(vertices, vertices[1:], strict=False):
        chord = segments.points[end] - segments.points[begin]
        offsets = segments.points[begin:end] - segments.points[begin]
        distances.append(np.abs(chord[0] * offsets[:, 1] - chord[1] * offsets[:, 0]).max() / np.hypot(*chord))
    assert 0.4 * tolerance < max(distances) <= tolerance


def test_polyline_of_a_square_bends_at_its_corners_and_stays_near_the_points():
    corners = turned_rectangle((50, 45), 40.0, 40.0, 0.2)
    segments = segments_of(polygon_photo(corners))
    vertices = segments.points[segments.vertex_indices]
    for corner in corners:
        assert np.hypot(*(vertices - corner).T).min() < 2.5
    assert len(vertices) < 14


def test_noise_and_weak_lines_are_removed_by_length_and_threshold():
    image = polygon_photo(turned_rectangle((50, 45), 40.0, 20.0, 0.2), contrast=-30.0)
    assert len(segments_of(image)) >= 1
    assert len(segments_of(image, threshold=40.0)) == 0
    assert len(segments_of(image, length_min=500.0)) == 0
    strongest = np.hypot(*extract_edges(image, EdgeSettings()).gradients.T).max()
    weak = 1.2 * strongest
    assert len(extract_edges(image, EdgeSettings(threshold=weak)).points) > 0
    assert len(segments_of(image, threshold=weak)) == 0


def test_an_even_image_has_no_edges_and_no_segments():
    even = np.full((40, 50), 90, np.uint8)
    assert len(extract_edges(even, EdgeSettings()).points) == len(segments_of(even)) == 0


@pytest.mark.parametrize('tolerance', [0.3, 1.0, 4.0])
def test_no_point_is_farther_from_the_polyline_than_the_tolerance(tolerance):
    t = np.linspace(0.0, 3.0, 200)
    points = np.column_stack([40 * t, 25 * np.sin(2 * t)])
    vertex_indices, _ = polyline_vertices(points, np.array([0, 200], np.int32), tolerance)
    for a, b in zip(vertex_indices[:-1], vertex_indices[1:]):
        chord = (points[b] - points[a]) / np.hypot(*(points[b] - points[a]))
        offsets = points[a : b + 1] - points[a]
        assert np.abs(chord[0] * offsets[:, 1] - chord[1] * offsets[:, 0]).max() <= tolerance


def test_a_straight_segment_has_its_ends_only_and_the_next_one_its_own():
    line = np.column_stack([np.arange(10.0), np.zeros(10)])
    points = np.concatenate([line, line + 50])
    vertex_indices, starts = polyline_vertices(points, np.array([0, 10, 20], np.int32), 0.5)
    assert vertex_indices.tolist() == [0, 9, 10, 19]
    assert starts.tolist() == [0, 2, 4]


def test_links_go_to_one_point_from_one_point():
    edges = extract_edges(ellipse_photo((50, 45), (30.0, 20.0), 0.3, noise=8.0), EdgeSettings(threshold=3.0))
    successors = link_points(edges.points, edges.gradients, edges.index)
    linked = successors[successors >= 0]
    assert len(np.unique(linked)) == len(linked)


def test_chains_hold_each_point_once_open_ones_first():
    successors = np.array([1, 2, -1, 4, 3, -1], np.int32)
    order, starts, closed = extract_chains(successors, np.full(6, 10.0), 5.0, 2)
    assert order.tolist() == [0, 1, 2, 3, 4]
    assert starts.tolist() == [0, 3, 5]
    assert closed.tolist() == [False, True]


def test_one_strong_point_keeps_a_chain():
    successors = np.array([1, 2, -1, 4, -1], np.int32)
    order, starts, _ = extract_chains(successors, np.array([1.0, 9.0, 1.0, 4.0, 4.0]), 5.0, 2)
    assert order.tolist() == [0, 1, 2]
    assert starts.tolist() == [0, 3]
