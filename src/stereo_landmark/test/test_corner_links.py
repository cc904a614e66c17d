import numpy as np
import pytest

from stereo_landmark.core.primitives.corner_links import CornerLinks, link_corners, nearest_links


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


@pytest.mark.parametrize('count', [1, 2, 3])
def test_nearest_links_are_for_each_end_its_nearest_ones(count: int) -> None:
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
    assert len(few.gaps) < len(links.gaps)


def test_all_links_are_kept_where_each_end_has_few() -> None:
    links = link_corners(_random_sides(200), 30.0, 4.0, 0.35)
    assert len(nearest_links(links, 1000).gaps) == len(links.gaps)


def test_of_equally_near_links_the_first_is_kept() -> None:
    pair, gaps = np.array([[0, 1]] * 3), np.array([[2.0, 1.0], [1.0, 2.0], [-1.0, 2.0]])
    links = CornerLinks(pair, np.ones_like(pair), np.arange(6.0).reshape(3, 2), gaps, np.ones(3))
    np.testing.assert_array_equal(nearest_links(links, 1).vertices, [[0.0, 1.0]])
