"""A rectangle is not skewed from any viewpoint; one with a mismatched side is reported."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_wall import Plate, Wall, view_of

from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import ImageProcessing
from stereo_landmark.core.teaching.geometry_hints import find_skewed_shapes
from stereo_landmark.core.teaching.teaching_state import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

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
