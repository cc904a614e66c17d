import numpy as np
import pytest

from stereo_landmark.core.primitives.corner import intersect_lines, intersect_with_covariance, joint_corner_covariance
from stereo_landmark.core.primitives.corner_links import CornerLinks, link_corners, nearest_links
from stereo_landmark.core.primitives.line_refinement import RefinedLine


def _random_sides(count):
    rng = np.random.default_rng(count)
    begins = rng.uniform(0.0, 300.0, (count, 2))
    angles, lengths = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(5.0, 60.0, count)
    steps = lengths[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    return np.stack([begins, begins + steps], axis=1)


def _all_pairs(ends, gap_max, overshoot_max, angle_min):
    """Return the pairs of end points that form corners, by brute force."""
    found = set()
    places = ends.reshape(-1, 2)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    outward = np.stack([ends[:, 0] - ends[:, 1], ends[:, 1] - ends[:, 0]], axis=1) / lengths[:, None, None]
    outward = outward.reshape(-1, 2)
    for a in range(len(places)):
        for b in range(a + 1, len(places)):
            matrix = np.column_stack([outward[a], -outward[b]])
            if a // 2 == b // 2 or abs(np.linalg.det(matrix)) < np.sin(angle_min):
                continue
            gaps = np.linalg.solve(matrix, places[b] - places[a])
            reaches = [min(gap_max, max(lengths[k // 2], overshoot_max)) for k in (a, b)]
            overshoots = [min(overshoot_max, 0.5 * lengths[k // 2]) for k in (a, b)]
            is_near = (np.abs(places[b] - places[a]) <= sum(reaches)).all()
            if is_near and all(-o <= g <= r for o, g, r in zip(overshoots, gaps, reaches, strict=True)):
                found.add((a, b))
    return found


def test_links_are_those_that_trying_all_pairs_finds():
    ends = _random_sides(120)
    links = link_corners(ends, 30.0, 4.0, 0.35)
    found = {tuple(sorted(pair)) for pair in (2 * links.lines + links.ends).tolist()}
    assert found == _all_pairs(ends, 30.0, 4.0, 0.35)
    assert len(found) == len(links.gaps) > 50


def test_no_sides_make_no_links():
    assert len(link_corners(np.empty((0, 2, 2)), 30.0, 4.0, 0.35).gaps) == 0


@pytest.mark.parametrize('count', [1, 2, 3, 1000])
def test_nearest_links_are_for_each_end_its_nearest_ones_or_all_where_it_has_few(count):
    links = link_corners(_random_sides(200), 30.0, 4.0, 0.35)
    gaps = np.abs(links.gaps).sum(axis=1)
    nodes = 2 * links.lines + links.ends
    wanted = {
        m
        for column in nodes.T
        for node in np.unique(column)
        for m in sorted(np.flatnonzero(column == node).tolist(), key=lambda m: gaps[m])[:count]
    }
    few = nearest_links(links, count)
    np.testing.assert_array_equal(few.vertices, links.vertices[sorted(wanted)])
    assert (len(few.gaps) < len(links.gaps)) is (count < 1000)


def test_of_equally_near_links_the_first_is_kept():
    pair, gaps = np.array([[0, 1]] * 3), np.array([[2.0, 1.0], [1.0, 2.0], [-1.0, 2.0]])
    links = CornerLinks(pair, np.ones_like(pair), np.arange(6.0).reshape(3, 2), gaps, np.ones(3))
    np.testing.assert_array_equal(nearest_links(links, 1).vertices, [[0.0, 1.0]])


def _line(x, y, angle, offset=0.01, turn=0.001):
    direction = np.array([np.cos(angle), np.sin(angle)])
    return RefinedLine(np.array([x, y]), direction, np.array([offset**2, turn**2]), 0.7, 1.0)


def _moved(line, rng):
    offset, turn = np.sqrt(line.variances) * rng.standard_normal(2)
    normal = np.array([-line.direction[1], line.direction[0]])
    angle = np.arctan2(line.direction[1], line.direction[0]) + turn
    return _line(*(line.middle + offset * normal), angle)


LINES = [_line(50, 20, 0.1), _line(80, 45, 1.4, 0.02), _line(50, 70, 3.0), _line(20, 45, -1.5, 0.01, 0.002)]


def test_lines_meet_on_both():
    vertex = intersect_lines(LINES[0], LINES[1])
    for line in LINES[:2]:
        assert abs(np.linalg.det(np.stack([line.direction, vertex - line.middle]))) < 1e-9


def test_covariance_is_that_of_moved_lines():
    rng = np.random.default_rng(0)
    vertices = [intersect_lines(_moved(LINES[0], rng), _moved(LINES[1], rng)) for _ in range(4000)]
    _, covariance = intersect_with_covariance(LINES[0], LINES[1])
    np.testing.assert_allclose(np.cov(np.transpose(vertices)), covariance, rtol=0.1, atol=1e-5)


def test_joint_covariance_is_that_of_moved_lines_and_its_blocks_those_of_single_crossings():
    rng = np.random.default_rng(0)

    def corners(lines):
        return np.array([intersect_lines(lines[k - 1], lines[k]) for k in range(4)])

    covariance = joint_corner_covariance(LINES, corners(LINES))
    samples = [corners([_moved(line, rng) for line in LINES]).ravel() for _ in range(4000)]
    np.testing.assert_allclose(np.cov(np.transpose(samples)), covariance, atol=0.1 * covariance.max())
    _, single = intersect_with_covariance(LINES[1], LINES[2])
    np.testing.assert_allclose(covariance[4:6, 4:6], single, rtol=1e-9)
