from dataclasses import replace

import numpy as np
import pytest
from drawn_wall import Disc, Wall, look
from taught_wall import RIG, TAUGHT, seen, taught_place

from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import ImageProcessing, StereoView, detect_scene
from stereo_landmark.core.teaching.geometry_hints import check_place
from stereo_landmark.core.teaching.teaching_state import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher


def with_points(count):
    """Return the place with only some of its points, of meters from the left."""
    place = taught_place()
    (target,) = place.targets
    return replace(place, targets=(replace(target, points=target.points[:count]),))


def taught_from(images, chosen):
    """Return a place with some of the detected ellipses, counted from the left."""
    processing = ImageProcessing()
    left, right = (detect_scene(image, processing) for image in images)
    ellipses = sorted(left.kinds[PrimitiveKind.ELLIPSE].primitives, key=lambda e: e.centre[0])
    choice = TargetSelection('meters', {f'meter {i}': ellipses[i] for i in chosen})
    return Teacher(StereoView(left, right, RIG), processing).teach('wall', [choice])


def test_a_good_place_has_no_weakness():
    assert check_place(taught_place(), *seen(TAUGHT)) == []


def test_too_few_points_are_reported():
    (line,) = check_place(with_points(3), *seen(TAUGHT))
    assert line == 'too few points: 3, select 4 or more, since some may be hidden'
    assert any('too few points' in line for line in check_place(with_points(1), *seen(TAUGHT)))


def test_one_of_many_similar_targets_is_reported_as_ambiguous():
    """The paper's five meters: two of them alone could be any two neighbours."""
    wall = Wall(tuple(Disc(0.6 - 0.28 * i, 0.75, 0.09, 60.0) for i in range(5)))
    images = look(wall, np.zeros(6), RIG)
    place = replace(taught_from(images, [1, 2]), context_landmarks=())
    lines = check_place(place, *images)
    assert any(line.startswith('target meters: ambiguous: several poses match') for line in lines)


@pytest.mark.parametrize(
    ('distance', 'words'), [(2.5, 'too shallow: at 2.'), (5.0, 'the displacement is too uncertain')]
)
def test_close_points_are_reported_as_narrow_and_uncertain(distance, words):
    places = ((0.1, 1.0, 40.0), (-0.12, 1.1, 230.0), (0.1, 0.7, 90.0), (-0.13, 0.8, 30.0))
    wall = Wall(tuple(Disc(y, z, 0.09, level) for y, z, level in places), distance=distance)
    images = look(wall, np.zeros(6), RIG)
    lines = check_place(taught_from(images, range(4)), *images)
    assert any(line.startswith('too narrow: the horizontal extent is 0.2') for line in lines)
    assert any(line.startswith(words) for line in lines), lines
