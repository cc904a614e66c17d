"""Merge observations into dots, and count the images that should have observed a dot."""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from floor_localizer.core.arrays import Booleans, Floats, Ints
from floor_localizer.core.survey.survey_image import ViewOutline
from shirube_core.geometry import SE2

_MAX_SPLITS = 4


def merge_observations(points: Floats, image: Ints, merge_distance: float) -> Ints:
    """Merge observations into dots: single-linkage clusters of observations from different images.

    A cluster with two observations of one image, which are two dots, is split with half the merge distance.

    Args:
        points: observations on the map, shape (n, 2) [m].
        image: image of each observation, shape (n,).
        merge_distance: merge distance [m].

    Returns:
        the dot number of each observation, from 0 without gaps, shape (n,).
    """
    labels = np.arange(len(points))
    unassigned = np.arange(len(points))
    for _ in range(_MAX_SPLITS):
        if len(unassigned) == 0:
            break
        clusters = cluster_observations(points[unassigned], image[unassigned], merge_distance)
        is_consistent = ~_has_duplicates(clusters, image[unassigned])
        first = np.full(int(clusters.max(initial=-1)) + 1, -1)
        first[clusters[::-1]] = unassigned[::-1]
        labels[unassigned[is_consistent]] = first[clusters[is_consistent]]
        unassigned = unassigned[~is_consistent]
        merge_distance *= 0.5
    return np.unique(labels, return_inverse=True)[1].astype(np.int64)


def cluster_observations(points: Floats, image: Ints, merge_distance: float) -> Ints:
    """Return the cluster number of each observation; arguments as for `merge_observations`."""
    if len(points) == 0:
        return np.empty(0, dtype=np.int64)
    pairs = cKDTree(points).query_pairs(merge_distance, output_type='ndarray')
    pairs = pairs[image[pairs[:, 0]] != image[pairs[:, 1]]]
    links = sparse.coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    return connected_components(links, directed=False)[1].astype(np.int64)


def _has_duplicates(clusters: Ints, image: Ints) -> Booleans:
    """Return for each observation whether its cluster contains two observations of one image."""
    order = np.lexsort((image, clusters))
    same = (np.diff(clusters[order]) == 0) & (np.diff(image[order]) == 0)
    bad = np.zeros(int(clusters.max(initial=-1)) + 1, dtype=np.bool_)
    bad[clusters[order][1:][same]] = True
    return bad[clusters]


def count_expected_views(dots: Floats, states: Floats, outline: ViewOutline, margin: float) -> Ints:
    """Return the number of images that should have observed each dot, shape (m,).

    ``states`` are those of all images that may have observed any of them; in a border of the view as wide as ``margin``
    [m] a dot may be cut off.
    """
    counts = np.zeros(len(dots), dtype=np.int64)
    if len(dots) == 0:
        return counts
    tree = cKDTree(dots)
    for place, state in zip(outline.centres(states), states, strict=True):
        pose = SE2(*(float(value) for value in state[:3]))
        near = np.array(tree.query_ball_point(place, outline.radius), dtype=np.int64)
        counts[near[outline.contains(pose.inverse().transform(dots[near]), margin)]] += 1
    return counts
