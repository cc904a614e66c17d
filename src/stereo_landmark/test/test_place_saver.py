"""Two sessions and one folder: no changes are overwritten without confirmation, and no stale files remain."""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest
from taught_wall import taught_place
from teaching_wall import images_of

from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.files.place_file import load_images
from stereo_landmark.page.place_saver import PlaceExistsError, PlaceSaver


def images_with(level):
    """Return the taught pair with a unique mark."""
    left = images_of(0).left.copy()
    left[:4, :4] = level
    return StereoImages(left, images_of(0).right)


def test_what_another_saved_since_is_replaced_only_on_purpose(tmp_path):
    path = PlaceSaver(tmp_path).save(taught_place(), images_with(0))
    one, other = PlaceSaver(tmp_path, [path]), PlaceSaver(tmp_path, [path])
    one.save(taught_place(), images_with(1))
    with pytest.raises(PlaceExistsError, match='was changed elsewhere'):
        other.save(taught_place(), images_with(2))
    assert load_images(path).left[0, 0] == 1
    other.save(taught_place(), images_with(2), replace=True)
    other.save(taught_place(), images_with(3))
    assert load_images(path).left[0, 0] == 3


def test_images_of_places_that_were_saved_at_once_are_not_left_behind(tmp_path):
    savers, together = [PlaceSaver(tmp_path) for _ in range(2)], Barrier(2)

    def work(number):
        for turn in range(4):
            together.wait()
            savers[number].save(taught_place(), images_with(10 * turn + number), replace=True)

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(work, range(2)))
    assert len(list(tmp_path.glob('*.png'))) == 2
    assert np.array_equal(load_images(tmp_path / 'wall.yaml').right, images_of(0).right)
