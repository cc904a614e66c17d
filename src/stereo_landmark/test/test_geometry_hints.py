"""Weak geometry, shapes that are no rectangles and targets that are not found are reported."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_wall import Disc, Plate, Wall, look, view_of
from place_scenes import RIG, panel, teach, view
from taught_wall import RIG as SMALL_RIG

from stereo_landmark.commands.teach import undetected_targets
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.place.place_locator import PlaceLocator
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.teaching.hints import (
    check_geometry,
    count_distinct_points,
    find_skewed_shapes,
    horizontal_extent,
)
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher


def warnings(points, noise=0.1):
    """Return the warnings for points in front of the cameras."""
    taught = teach(points, noise, np.random.default_rng(1))
    seen = view(points, np.zeros(6), noise, np.random.default_rng(2))
    fix = PlaceLocator(RIG, PlaceSettings(position_sigma_max=10.0)).locate(seen, taught)
    return check_geometry(taught.positions, fix)


def test_many_points_far_apart_are_good():
    assert warnings(panel(3.0, 1.0, 16)) == []


def test_few_narrow_and_far_points_are_reported():
    assert any(line.startswith('too few points: 3') for line in warnings(panel(3.0, 1.0, 3)))
    assert any(line.startswith('too narrow') for line in warnings(panel(3.0, 0.2, 8)))
    far = warnings(panel(6.0, 0.1, 4, depth=0.02, seed=3))
    assert any(line.startswith('too shallow: at 6.') for line in far), far
    assert any('yaw has a standard deviation of' in line for line in far)


def test_rims_around_one_centre_are_one_spot():
    meters = panel(3.0, 1.0, 2, depth=0.0)
    rims = np.vstack([meters, meters + 0.001])
    assert any(
        line.startswith('too close together: 4 points at 2 distinct positions') for line in warnings(rims)
    )
    assert count_distinct_points(rims) == count_distinct_points(rims[::-1]) == 2
    assert count_distinct_points(panel(3.0, 1.0, 16)) == 16


def test_the_width_does_not_change_with_the_direction_of_the_wall():
    points = panel(depth=0.0)
    points[:2, 1] = -0.4, 0.4
    for angle in (0.0, 0.7, 2.0):
        cos, sin = np.cos(angle), np.sin(angle)
        turned = points @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        assert np.isclose(horizontal_extent(turned), 0.8)


def test_the_worst_direction_counts():
    points = panel()
    fix = PlaceLocator(RIG).locate(view(points, np.zeros(6), 0.1, np.random.default_rng(1)), teach(points))
    position, yaw = fix.position_sigma, fix.yaw_sigma
    assert position >= np.sqrt(np.diag(fix.covariance)[:2].max())
    assert yaw == np.sqrt(fix.covariance[3, 3])


WALL = Wall((Plate(0.4, 0.7, 0.5, 0.3, 60.0), Plate(-0.4, 0.7, 0.3, 0.2, 220.0)))


def taught(yaw):
    view = view_of(
        WALL,
        (0.0, 0.0, 0.0, yaw, 0.0, 0.0),
        (PrimitiveKind.QUADRILATERAL, PrimitiveKind.ELLIPSE, PrimitiveKind.CORNER),
    )
    plates = sorted(
        view.left.kinds[PrimitiveKind.QUADRILATERAL].primitives, key=lambda plate: plate.centre[0]
    )
    assert len(plates) == 2
    choice = TargetSelection('signs', {f'plate {k}': plate for k, plate in enumerate(plates)})
    return Teacher(view, ImageProcessing()).teach('hall', [choice])


def remarks(place):
    shapes = {f'signs/{primitive.name}': primitive.shape for primitive in place.targets[0].primitives}
    return find_skewed_shapes(shapes, place.coordinates)


@pytest.mark.parametrize('yaw', [-0.2, 0.0, 0.2])
def test_rectangles_are_rectangles_from_everywhere(yaw):
    assert list(remarks(taught(yaw))) == []


def test_a_mismatched_side_is_reported():
    """The corners of one side move along their rays, as with a wrong disparity of that side."""
    place = taught(0.0)
    positions = place.coordinates.positions.copy()
    names = place.coordinates.names
    eye = place.rig.mount.xyz
    side = [
        names.index(f'signs/plate 0/{name}')
        for name in sorted(
            (f'corner_{k}' for k in range(4)), key=lambda name: positions[_row(names, name), 1]
        )[:2]
    ]
    positions[side] = eye + 1.1 * (positions[side] - eye)
    place = replace(place, coordinates=replace(place.coordinates, positions=positions))
    ((name, line),) = remarks(place)
    assert name == 'signs/plate 0'
    assert line.startswith('signs/plate 0: its opposite sides are ')
    assert np.abs(positions[side, 0] - 3.0).min() > 0.2


def _row(names, name):
    return names.index(f'signs/plate 0/{name}')


def undetected(wall, chosen):
    """Return the remarks about some ellipses of a wall, counted from the left, taught without context landmarks."""
    processing, images = ImageProcessing(), look(wall, np.zeros(6), SMALL_RIG)
    left, right = (detect_scene(image, processing) for image in images)
    ellipses = sorted(left.kinds[PrimitiveKind.ELLIPSE].primitives, key=lambda e: e.centre[0])
    choice = TargetSelection('meters', {f'meter {i}': ellipses[i] for i in chosen})
    place = Teacher(StereoView(left, right, SMALL_RIG), processing).teach('wall', [choice])
    return undetected_targets(LandmarkLocalizer([replace(place, context_landmarks=())]).locate(*images))


def test_targets_that_are_ambiguous_or_uncertain_in_their_own_images_are_reported():
    """The paper's five meters: two of them alone could be any two neighbours."""
    meters = tuple(Disc(0.6 - 0.28 * i, 0.75, 0.09, 60.0) for i in range(5))
    (line,) = undetected(Wall(meters), [1, 2])
    assert line.startswith('target meters: ambiguous: several poses match')
    places = ((0.1, 1.0, 40.0), (-0.12, 1.1, 230.0), (0.1, 0.7, 90.0), (-0.13, 0.8, 30.0))
    narrow = tuple(Disc(y, z, 0.09, level) for y, z, level in places)
    (line,) = undetected(Wall(narrow, distance=5.0), range(4))
    assert line.startswith('the displacement is too uncertain even in the taught images')
    assert undetected(Wall(narrow, distance=2.5), range(4)) == []
