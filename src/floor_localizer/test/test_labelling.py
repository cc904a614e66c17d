import numpy as np
from scipy import ndimage

from floor_localizer.core.dot_extraction.labelling import (
    DISCARDED,
    SURROUNDINGS_WIDTH,
    bounding_boxes,
    grow_labels,
    label_blobs,
)


def test_labels_and_boxes_agree_with_scipy():
    mask = (np.random.default_rng(0).uniform(size=(60, 80)) > 0.6).astype(np.uint8)
    labels, boxes = label_blobs(mask)
    expected, count = ndimage.label(mask)
    assert len(boxes) == count
    for number, (rows, columns) in enumerate(ndimage.find_objects(expected), start=1):
        label = labels[expected == number]
        assert np.unique(label).size == 1
        box = [columns.start, rows.start, columns.stop, rows.stop, label.size]
        np.testing.assert_array_equal(boxes[label[0] - 1], box)


def test_branches_that_meet_below_are_one_blob_and_pixels_that_touch_in_a_corner_two():
    mask = np.array([[1, 0, 1, 0, 1], [1, 0, 1, 0, 1], [1, 1, 1, 1, 1]], np.uint8)
    assert len(label_blobs(mask)[1]) == 1
    assert len(label_blobs(np.eye(2, dtype=np.uint8))[1]) == 2


def test_boxes_leave_out_floor_and_discarded_pixels():
    labels = np.array([[0, DISCARDED, 1], [-1, 1, 1]], dtype=np.int32)
    np.testing.assert_array_equal(bounding_boxes(labels, 1), [[1, 0, 3, 2, 3]])
    labels, boxes = label_blobs(np.zeros((20, 30), np.uint8))
    assert boxes.shape == (0, 5)
    assert not labels.any()


def test_specks_stay_floor_and_dots_count_from_one():
    mask = np.zeros((40, 43), np.uint8)
    mask[5:7, 5:6] = mask[20:26, 20:26] = mask[30:33, 40:43] = 255
    labels, boxes = label_blobs(mask, 4.0)
    assert not labels[:10].any()
    np.testing.assert_array_equal(boxes, [[20, 20, 26, 26, 36], [40, 30, 43, 33, 9]])
    np.testing.assert_array_equal(np.unique(labels[20:26, 20:26]), [1])


def test_runs_do_not_go_on_in_the_next_row_whatever_the_width():
    for width in range(1, 18):
        mask = np.zeros((3, width), np.uint8)
        mask[0, -1] = mask[2, 0] = 1
        assert len(label_blobs(mask)[1]) == 2


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
