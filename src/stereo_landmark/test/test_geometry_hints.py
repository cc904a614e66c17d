"""Weak geometry, shapes that are no rectangles and targets that are not found are reported."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_wall import Disc, Plate, Wall, detect_view, from_left, look, teach_view, view_of
from meter_walls import ALONE
from place_scenes import RIG, panel, teach, view
from taught_wall import RIG as SMALL_RIG

from stereo_landmark.commands.teach import undetected_targets
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.place.place_locator import PlaceLocator
from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.teaching.hints import (
    check_geometry,
    count_distinct_points,
    find_skewed_shapes,
    horizontal_extent,
)

RIMS = np.vstack([panel(3.0, 1.0, 2, depth=0.0) + step for step in (0.0, 0.001)])
"""Two rims around each of two centres."""


@pytest.mark.parametrize(
    ('points', 'beginnings'),
    [
        (panel(3.0, 1.0, 16), []),
        (panel(3.0, 1.0, 3), ['too few points: 3']),
        (panel(3.0, 0.2, 8), ['too narrow']),
        (panel(6.0, 0.1, 4, 0.02, 3), ['too shallow: at 6.', 'the heading is only known to ±']),
        (RIMS, ['too close together: 4 points at 2 distinct positions']),
    ],
)
def test_few_narrow_far_and_coinciding_points_are_reported_and_no_others(points, beginnings):
    taught = teach(points, 0.1, np.random.default_rng(1))
    seen = view(points, np.zeros(6), 0.1, np.random.default_rng(2))
    fix = PlaceLocator(RIG, PlaceSettings(position_sigma_max=10.0)).locate(seen, taught)
    assert fix.position_sigma >= np.sqrt(np.diag(fix.covariance)[:2].max())  # in the worst direction
    warnings = check_geometry(taught.positions, fix)
    assert bool(warnings) == bool(beginnings)
    for beginning in beginnings:
        assert any(line.startswith(beginning) for line in warnings), warnings


def test_rims_around_one_centre_are_one_spot():
    assert count_distinct_points(RIMS) == count_distinct_points(RIMS[::-1]) == 2
    assert count_distinct_points(panel(3.0, 1.0, 16)) == 16


def test_the_width_does_not_change_with_the_direction_of_the_wall():
    points = panel(depth=0.0)
    points[:2, 1] = -0.4, 0.4
    for angle in (0.0, 0.7, 2.0):
        cos, sin = np.cos(angle), np.sin(angle)
        turned = points @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        assert np.isclose(horizontal_extent(turned), 0.8)


WALL = Wall((Plate(0.4, 0.7, 0.5, 0.3, 60.0), Plate(-0.4, 0.7, 0.3, 0.2, 220.0)))


def taught(yaw):
    view = view_of(WALL, (0.0, 0.0, 0.0, yaw, 0.0, 0.0))
    plates = from_left(view, PrimitiveKind.QUADRILATERAL)
    assert len(plates) == 2
    return teach_view(view, {f'plate {k}': plate for k, plate in enumerate(plates)}, target='signs')


def remarks(place):
    shapes = {f'signs/{primitive.name}': primitive.shape for primitive in place.targets[0].primitives}
    return find_skewed_shapes(shapes, place.coordinates)


@pytest.mark.parametrize('yaw', [-0.2, 0.0, 0.2])
def test_rectangles_are_rectangles_from_everywhere(yaw):
    assert list(remarks(taught(yaw))) == []


def test_a_mismatched_side_is_reported():
    """The corners of one side move along their rays, as with a wrong disparity of that side."""
    place = taught(0.0)
    positions, eye = place.coordinates.positions.copy(), place.rig.mount.xyz
    corners = [k for k, name in enumerate(place.coordinates.names) if name.startswith('signs/plate 0/corner')]
    side = sorted(corners, key=lambda k: positions[k, 1])[:2]
    positions[side] = eye + 1.1 * (positions[side] - eye)
    place = replace(place, coordinates=replace(place.coordinates, positions=positions))
    ((name, line),) = remarks(place)
    assert name == 'signs/plate 0'
    assert line.startswith('signs/plate 0: its opposite sides are ')
    assert np.abs(positions[side, 0] - 3.0).min() > 0.2


def undetected(wall, chosen):
    """Return the remarks about some ellipses of a wall, counted from the left, taught without context landmarks."""
    images = look(wall, np.zeros(6), SMALL_RIG)
    view = detect_view(images, SMALL_RIG)
    ellipses = from_left(view)
    place = teach_view(view, {f'meter {i}': ellipses[i] for i in chosen}, target='meters')
    return undetected_targets(LandmarkLocalizer([replace(place, context_landmarks=())]).locate(*images))


def test_targets_that_are_ambiguous_or_uncertain_in_their_own_images_are_reported():
    """The paper's five meters: two of them alone could be any two neighbours."""
    (line,) = undetected(ALONE, [1, 2])
    assert line.startswith('target meters: ambiguous: several poses match')
    places = ((0.1, 1.0, 40.0), (-0.12, 1.1, 230.0), (0.1, 0.7, 90.0), (-0.13, 0.8, 30.0))
    narrow = tuple(Disc(y, z, 0.09, level) for y, z, level in places)
    (line,) = undetected(Wall(narrow, distance=5.0), range(4))
    assert line.startswith('the displacement is too uncertain even in the taught images')
    assert undetected(Wall(narrow, distance=2.5), range(4)) == []
