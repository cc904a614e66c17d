import numpy as np
from scipy import ndimage

from floor_localizer.core.dot_extraction.labelling import (
    DISCARDED,
    SURROUNDINGS_WIDTH,
    grow_labels,
    label_blobs,
)


def grown_labels(mask):
    labels, boxes = label_blobs(mask.astype(np.uint8))
    grow_labels(labels, boxes)
    return labels


def disc(u, v, diameter, size=60):
    y, x = np.mgrid[:size, :size]
    return np.hypot(x - u, y - v) <= diameter / 2


def test_a_blob_gets_a_soft_edge_and_a_ring_about_as_wide_as_each_other():
    mask = disc(30, 30, 11)
    labels = grown_labels(mask)
    distance = ndimage.distance_transform_edt(~mask)
    np.testing.assert_array_equal(labels[mask], 1)
    assert distance[labels == 1].max() < 3.0
    assert distance[labels == 0].min() > SURROUNDINGS_WIDTH - 1
    ring = distance[labels == -1]
    assert ring.min() > 1.5
    assert ring.max() <= SURROUNDINGS_WIDTH + 2.0


def test_between_two_blobs_the_border_runs_half_way():
    labels = grown_labels(disc(24, 30, 9) | disc(36, 30, 9))
    left, right = np.abs(labels[30, 20:30]), np.abs(labels[30, 31:41])
    assert set(left) == {1}
    assert set(right) == {2}
    sizes = [np.count_nonzero(np.abs(labels) == label) for label in (1, 2)]
    assert abs(sizes[0] - sizes[1]) < 0.1 * sizes[0]


def test_growth_stops_at_the_image_border_and_at_discarded_pixels():
    mask = np.zeros((12, 12), bool)
    mask[0:3, 0:3] = True
    labels, boxes = label_blobs(mask.astype(np.uint8))
    labels[3, :] = DISCARDED
    grow_labels(labels, boxes)
    assert (labels[4:] == 0).all()
    assert (labels[3] == DISCARDED).all()
    assert labels[0, 4] == 1
