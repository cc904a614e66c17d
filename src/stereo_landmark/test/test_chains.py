import numpy as np
from seen_shapes import ellipse_photo

from stereo_landmark.core.edges.chains import extract_chains, link_points
from stereo_landmark.core.edges.edges import extract_edges
from stereo_landmark.core.settings import EdgeSettings


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
