import numpy as np
import pytest
from drawn_floor import disc_coverage, line_coverage, photograph

from floor_localizer.core.dot_extraction.labelling import DISCARDED, label_blobs
from floor_localizer.core.dot_extraction.splitting import split_touching

BACKGROUND = np.full((160, 160, 1), 160.0, np.float32)


def split(coverage):
    image = photograph(coverage)[..., None]
    labels, boxes = label_blobs((coverage > 0.3).astype(np.uint8))
    boxes, parts = split_touching(labels, boxes, image, BACKGROUND, 'dark', 3.0, 25.0)
    return labels, boxes, parts


@pytest.mark.parametrize('diameter', [5.0, 8.0, 20.0])
def test_a_disc_stays_one_blob(diameter):
    labels, boxes, parts = split(disc_coverage([[80.4, 60.3]], diameter))
    assert len(boxes) == 1
    assert not parts.any()
    assert set(np.unique(labels)) == {0, 1}


@pytest.mark.parametrize('diameter', [6.0, 9.0, 20.0])
def test_three_touching_discs_become_three_parts_with_their_boxes(diameter):
    centres = np.array([80.0, 60.0]) + diameter * np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.866]])
    labels, boxes, parts = split(disc_coverage(centres, diameter))
    assert len(boxes) == 3
    assert parts.all()
    found = {labels[round(v), round(u)] for u, v in centres}
    assert found == {1, 2, 3}
    for label, box in enumerate(boxes, start=1):
        v, u = np.nonzero(labels == label)
        np.testing.assert_array_equal(box, [u.min(), v.min(), u.max() + 1, v.max() + 1, v.size])


def test_a_hair_on_a_dot_is_discarded():
    hair = line_coverage((50.0, 60.0), (110.0, 64.0), 1.5)
    labels, boxes, parts = split(np.maximum(disc_coverage([[80.0, 62.0]], 9.0), hair))
    assert len(boxes) == 1
    assert parts.all()
    assert (labels == DISCARDED).sum() > 40
    assert boxes[0, 0] > 70
    assert boxes[0, 2] < 91
