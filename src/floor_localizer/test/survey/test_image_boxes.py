"""Images whose boxes overlap a tile: the same as by testing each image."""

import numpy as np
import pytest

from floor_localizer.core.survey.adjustment.block_partition import Tile, split_into_tiles, store_boxes
from floor_localizer.core.survey.array_store import MemoryArrayStore


@pytest.mark.parametrize('count', [1, 31, 32, 33, 500])
def test_exactly_the_images_whose_boxes_overlap_a_tile_are_found(count):
    rng = np.random.default_rng(count)
    centres = np.cumsum(rng.normal(0.0, 0.1, (count, 2)), axis=0)  # along a drive
    sizes = rng.uniform(0.0, 0.1, (count, 2))
    boxes = np.stack([centres - sizes, centres + sizes], axis=1)
    found = store_boxes(boxes, MemoryArrayStore())
    for tile in split_into_tiles(centres, 7):
        for each in (tile, tile.expanded(-0.05)):
            meets = [
                k
                for k, ((left, low), (right, high)) in enumerate(boxes.tolist())
                if left < each.upper[0]
                and right >= each.lower[0]
                and low < each.upper[1]
                and high >= each.lower[1]
            ]
            assert found.overlapping_images(each).tolist() == meets


def test_no_image_overlaps_an_empty_tile():
    found = store_boxes(np.array([[[0.0, 0.0], [1.0, 1.0]]]), MemoryArrayStore())
    assert len(found.overlapping_images(Tile(np.full(2, np.inf), np.full(2, -np.inf)))) == 0
