"""Images whose boxes overlap a tile: the same as by testing each image."""

import numpy as np
import pytest

from floor_localizer.core.survey.image_boxes import shelve_boxes
from floor_localizer.core.survey.shelf import MemoryShelf
from floor_localizer.core.survey.tiles import Tile, cut_tiles


@pytest.mark.parametrize('count', [1, 31, 32, 33, 500])
def test_all_whose_boxes_meet_a_tile_are_found_and_no_others(count: int) -> None:
    rng = np.random.default_rng(count)
    middles = np.cumsum(rng.normal(0.0, 0.1, (count, 2)), axis=0)  # along a drive
    sizes = rng.uniform(0.0, 0.1, (count, 2))
    boxes = np.stack([middles - sizes, middles + sizes], axis=1)
    found = shelve_boxes(boxes, MemoryShelf())
    for tile in cut_tiles(middles, 7):
        for each in (tile, tile.grown(-0.05)):
            meets = [
                k
                for k, ((left, low), (right, high)) in enumerate(boxes.tolist())
                if left < each.upper[0]
                and right >= each.lower[0]
                and low < each.upper[1]
                and high >= each.lower[1]
            ]
            assert found.meeting(each).tolist() == meets


def test_nothing_lies_in_an_empty_place() -> None:
    found = shelve_boxes(np.array([[[0.0, 0.0], [1.0, 1.0]]]), MemoryShelf())
    assert len(found.meeting(Tile(np.full(2, np.inf), np.full(2, -np.inf)))) == 0
