import numpy as np
import pytest

from floor_localizer.core.dot_extraction.centroids import Blobs
from floor_localizer.core.dot_extraction.labelling import label_blobs
from floor_localizer.core.dot_extraction.noise_removal import are_dots, remove_specks, typical_diameter
from floor_localizer.core.dot_extraction.settings import DotDetectorSettings


def round_blobs(count=12, diameter=6.0):
    area = np.pi * diameter**2 / 4
    boxes = np.array([[10 + 9 * i, 20, 16 + 9 * i, 26, area] for i in range(count)], dtype=np.int32)
    blobs = Blobs(
        pixels=boxes[:, :2] + 2.5,
        sigmas=np.full(count, 0.02),
        areas=np.full(count, area),
        covariances=np.tile([diameter**2 / 16, 0.0, diameter**2 / 16], (count, 1)),
        contrasts=np.full(count, 0.8),
        steps=np.zeros(count),
        clipped=np.zeros(count),
    )
    return blobs, boxes


def kept(blobs, boxes, **settings):
    return are_dots(blobs, boxes, 235, 235, DotDetectorSettings(**settings))


def test_round_blobs_are_dots():
    assert kept(*round_blobs()).all()


@pytest.mark.parametrize(
    ('what', 'value'),
    [
        ('areas', 3.0),
        ('areas', 900.0),
        ('covariances', (40.0, 0.0, 1.0)),
        ('contrasts', 0.0),
        ('steps', 0.7),
        ('clipped', 0.3),
    ],
)
def test_one_that_is_not_like_a_dot_is_told_from_the_others(what, value):
    blobs, boxes = round_blobs()
    getattr(blobs, what)[4] = value
    assert list(np.flatnonzero(~kept(blobs, boxes))) == [4]


@pytest.mark.parametrize(('column', 'value'), [(0, 0), (1, 0), (2, 235), (3, 235)])
def test_one_at_the_border_is_no_dot(column, value):
    blobs, boxes = round_blobs()
    boxes[4, column] = value
    assert list(np.flatnonzero(~kept(blobs, boxes))) == [4]


def test_a_blur_that_stretches_all_alike_stretches_none():
    blobs, boxes = round_blobs()
    stretch = np.array([[5.0, 2.0], [0.0, 1.0]])
    moments = stretch @ stretch.T
    blobs.covariances[:] = moments[0, 0], moments[0, 1], moments[1, 1]
    assert kept(blobs, boxes, maximum_elongation=3.0).all()
    assert not kept(Blobs(*(a[:4] for a in blobs)), boxes[:4], maximum_elongation=3.0).any()


def test_an_exposure_that_saturates_all_is_no_reflection():
    blobs, boxes = round_blobs()
    blobs.clipped[:] = 0.6
    assert kept(blobs, boxes).all()


def test_specks_do_not_sway_the_typical_diameter():
    dots, specks = np.full(20, np.pi * 9.0), np.full(200, np.pi * 0.25)
    assert typical_diameter(np.append(dots, specks), 3.0, 25.0) == pytest.approx(6.0)
    assert typical_diameter(np.empty(0), 3.0, 25.0) == 3.0


def test_specks_become_floor_and_dots_stay():
    mask = np.zeros((40, 40), np.uint8)
    mask[5:7, 5:6] = mask[20:26, 20:26] = 1
    labels, boxes = label_blobs(mask)
    remove_specks(labels, boxes, 3.0)
    assert not labels[:10].any()
    assert (labels[20:26, 20:26] > 0).all()
    assert sorted(boxes[:, 4]) == [0, 36]
