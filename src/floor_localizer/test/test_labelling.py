import numpy as np
from scipy import ndimage

from floor_localizer.core.dot_extraction.labelling import DISCARDED, bounding_boxes, label_blobs


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


def test_pixels_that_touch_in_a_corner_are_two_blobs():
    assert len(label_blobs(np.eye(2, dtype=np.uint8))[1]) == 2


def test_boxes_leave_out_floor_and_discarded_pixels():
    labels = np.array([[0, DISCARDED, 1], [-1, 1, 1]], dtype=np.int32)
    np.testing.assert_array_equal(bounding_boxes(labels, 1), [[1, 0, 3, 2, 3]])


def test_an_empty_image_has_no_blob():
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


def test_branches_that_meet_below_are_one_blob():
    mask = np.array([[1, 0, 1, 0, 1], [1, 0, 1, 0, 1], [1, 1, 1, 1, 1]], np.uint8)
    assert len(label_blobs(mask)[1]) == 1


def test_runs_do_not_go_on_in_the_next_row_whatever_the_width():
    for width in range(1, 18):
        mask = np.zeros((3, width), np.uint8)
        mask[0, -1] = mask[2, 0] = 1
        assert len(label_blobs(mask)[1]) == 2
