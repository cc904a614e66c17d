import numpy as np
import pytest

from stereo_landmark.core.edges.segments import polyline_vertices


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
    vertex_indices, starts = polyline_vertices(
        np.concatenate([line, line + 50]), np.array([0, 10, 20], np.int32), 0.5
    )
    assert vertex_indices.tolist() == [0, 9, 10, 19]
    assert starts.tolist() == [0, 2, 4]
