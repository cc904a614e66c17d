"""Four of five identical meters are taught as one target."""

import numpy as np
import pytest
from drawn_wall import Plate, Wall, from_left, teach_view, view_of
from meter_walls import ALL, ALONE, row_of_meters
from place_scenes import RIG, errors_of

from stereo_landmark.core.place.joint_fit import reproject
from stereo_landmark.core.place.place_locator import PlaceFix, PlaceLocator
from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.procedure.target_search import NoDetectionReason, TargetDetection, TargetSearch

STATE = np.array([0.1, -0.05, 0.0, 0.03, 0.0, 0.0])
FIELDS = tuple(
    Plate(0.27 - 0.27 * (i % 3), 0.7 + 0.33 * (i // 3), 0.18, 0.24, level)
    for i, level in enumerate((60.0, 220.0, 200.0, 215.0, 205.0, 60.0))
)
PANEL = Wall((Plate(0.0, 0.86, 0.95, 0.85, 110.0), *FIELDS))


def taught(wall):
    """Teach the four meters on the left."""
    view = view_of(wall, np.zeros(6))
    meters = from_left(view)
    assert len(meters) == 5
    return teach_view(view, {f'meter {i}': meters[i] for i in range(4)}, target='meters')


@pytest.fixture(scope='module')
def place():
    return taught(ALL)


def search(place, wall, state):
    return TargetSearch(place).search(place.targets[0], view_of(wall, state))


@pytest.mark.parametrize('hidden', [None, 0, 1, 3, 4])
def test_the_meters_are_found_though_one_is_hidden(place, hidden):
    rng = np.random.default_rng(4 if hidden is None else hidden)  # None would be another case each time
    state = np.array([*rng.uniform(-0.3, 0.3, 2), 0.0, rng.uniform(-0.15, 0.15), 0.0, 0.0])
    found = search(place, ALL if hidden is None else ALL.without(hidden), state)
    assert found.found == tuple(f'meters/meter {i}' for i in range(4) if i != hidden)
    fix = PlaceLocator(RIG).locate(found.points, place.coordinates)
    assert isinstance(fix, PlaceFix)
    errors = np.abs(errors_of(fix.T_place_base, fix.height, state))
    assert (errors[[0, 1, 3]] < [0.005, 0.01, 0.005]).all()


def test_meters_without_surroundings_are_ambiguous_when_one_at_the_end_is_hidden():
    """Four equal meters in a row may be the first four or the last four."""
    place = taught(ALONE)
    assert isinstance(search(place, ALONE, STATE), TargetDetection)
    answer = search(place, ALONE.without(0), STATE)
    assert answer.reason is NoDetectionReason.AMBIGUOUS


def test_the_next_meter_in_a_narrow_row_is_taught_as_a_surrounding():
    """With the context landmark in view the four meters are the first four; without it they are ambiguous."""
    narrow = Wall(row_of_meters((0.45 - 0.215 * i for i in range(5)), 0.085))
    place = taught(narrow)
    assert [primitive.kind for primitive in place.context_landmarks] == [PrimitiveKind.ELLIPSE]
    assert isinstance(search(place, narrow, STATE), TargetDetection)


def test_spacing_alone_identifies_the_visible_meters():
    """Gaps that differ by 15 mm, 4 px, identify the last four, not the first."""
    uneven = Wall(row_of_meters(0.6 - np.cumsum([0.0, 0.28, 0.295, 0.28, 0.295])))
    found = search(taught(uneven), uneven.without(0), STATE)
    assert found.found == ('meters/meter 1', 'meters/meter 2', 'meters/meter 3')


@pytest.mark.parametrize('state', [(-0.1, -0.35, 0.05), (0.3, 0.3, -0.1), (0.2, 0.4, -0.15), (-0.3, 0.35, -0.2)])
@pytest.mark.newest_set_only
def test_fields_of_a_panel_are_not_mixed_up_with_each_other(state):
    """Sides of adjacent fields are collinear and form additional quadrilaterals."""
    view = view_of(PANEL, np.zeros(6))
    chosen = {}
    for i, field in enumerate(FIELDS):
        corners = np.array([[3.0, field.y + a, field.z + b] for a in (-0.09, 0.09) for b in (-0.12, 0.12)])
        middle = reproject(np.zeros(6), corners, RIG).pixels[:, :2].mean(axis=0)
        shapes = from_left(view, PrimitiveKind.QUADRILATERAL)
        near = [each for each in shapes if np.hypot(*(each.centre - middle)) < 2.0]
        width = 0.18 * RIG.left.fx / 3.0
        chosen[f'field {i}'] = min(near, key=lambda each: abs(np.ptp(each.corners[:, 0]) - width))
    place = teach_view(view, chosen)
    pose = np.array([state[0], state[1], 0.0, state[2], 0.0, 0.0])
    found = search(place, PANEL, pose)
    assert len(found.points) == 24
    expected = reproject(pose, place.coordinates.select(found.points.names).positions, RIG).pixels
    assert np.abs(found.points.pixels - expected).max() < 0.3
