"""Edits change the state as specified, and reject invalid input."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stereo_landmark.core.primitives.ellipse import Ellipse
from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching import edits
from stereo_landmark.core.teaching.edits import TeachingState, processing_values
from stereo_landmark.core.teaching.primitive_selection import Region


def ellipse(u):
    return Ellipse(np.array([u, 50.0]), np.array([9.0, 8.0]), 0.0, 1, 1.0, np.eye(5))


def names(state):
    return list(state.target.primitives)


@pytest.fixture
def three():
    state = TeachingState()
    for u in (10.0, 40.0, 70.0):
        state = edits.add_primitive(state, ellipse(u))
    return state


def test_chosen_primitives_come_last_under_names_of_their_own(three):
    assert names(three) == ['ellipse 1', 'ellipse 2', 'ellipse 3']
    again = edits.add_primitive(edits.remove_primitive(three, 'ellipse 2'), ellipse(99.0))
    assert names(again) == ['ellipse 1', 'ellipse 3', 'ellipse 2']


@pytest.mark.parametrize('place', [0, 1, 2, 9])
def test_a_moved_primitive_is_where_it_was_put_and_the_others_keep_their_order(three, place):
    moved = names(edits.move_primitive(three, 'ellipse 2', place))
    assert moved.index('ellipse 2') == min(place, 2)
    assert [name for name in moved if name != 'ellipse 2'] == ['ellipse 1', 'ellipse 3']


def test_points_follow_the_name_of_their_primitive_and_go_with_it(three):
    points = ['ellipse 1/centre', 'ellipse 3/centre']
    excluded = edits.set_points_used(three, points, used=False)
    renamed = edits.rename_primitive(excluded, 'ellipse 1', 'dial')
    assert renamed.target.excluded_points == {'dial/centre', 'ellipse 3/centre'}
    assert edits.remove_primitive(renamed, 'dial').target.excluded_points == {'ellipse 3/centre'}
    assert not edits.set_points_used(excluded, points, used=True).target.excluded_points


def test_each_target_has_its_own_primitives(three):
    second = edits.add_primitive(edits.add_target(three), ellipse(5.0))
    assert names(second) == ['ellipse 1']
    assert names(edits.activate_target(second, 0)) == names(three)
    assert names(edits.remove_target(second, 0)) == ['ellipse 1']
    assert edits.remove_target(second, 0).active == 0
    only = edits.remove_target(three, 0)
    assert names(only) == []
    assert only.target.name == 'target_1'


def test_a_number_of_the_image_processing_is_changed_and_reset():
    changed = edits.set_processing(TeachingState(), 'edges.threshold', 12)
    changed = edits.set_processing(changed, 'tolerances.ellipse.axes', 0.3)
    values = processing_values(changed.processing)
    assert values['edges.threshold'] == 12.0
    reset = processing_values(edits.reset_processing(changed, 'edges.').processing)
    assert reset == {**processing_values(TeachingState().processing), 'tolerances.ellipse.axes': 0.3}


def test_a_region_holds_what_is_wholly_inside():
    region = Region(10.0, 20.0, 30.0, 40.0)
    assert region.contains(np.array([[10.0, 20.0], [30.0, 40.0]]))
    assert not region.contains(np.array([[15.0, 25.0], [30.1, 30.0]]))
    drawn = edits.set_region(TeachingState(), region)
    assert drawn.target.region == region
    assert edits.set_region(drawn, replace(region)) is drawn


@pytest.mark.parametrize(
    ('step', 'said'),
    [
        (lambda s: edits.rename_place(s, 'a/b'), 'letters, digits'),
        (lambda s: edits.rename_place(s, ''), 'letters, digits'),
        (lambda s: edits.set_processing(s, 'edges.treshold', 1.0), 'did you mean edges.threshold'),
        (lambda s: edits.set_processing(s, 'edges.threshold', -1.0), 'allowed is 0.5 to 200'),
        (lambda s: edits.set_processing(s, 'edges.threshold', math.nan), 'edges.threshold'),
        (lambda s: edits.remove_primitive(s, 'meter'), 'it has ellipse 1, ellipse 2, ellipse 3'),
        (lambda s: edits.rename_primitive(s, 'ellipse 1', 'ellipse 2'), 'is taken'),
        (lambda s: edits.rename_primitive(s, 'ellipse 1', 'a/b'), 'without a slash'),
        (lambda s: edits.rename_target(edits.add_target(s), 1, 'target_1'), 'is taken'),
        (lambda s: edits.set_region(s, Region(5.0, 5.0, 6.0, 90.0)), 'too small'),
        (lambda s: edits.activate_target(s, 1), 'there is no target 2, there are 1'),
        (lambda s: edits.set_points_used(s, ['meter/centre'], used=True), 'has no primitive meter'),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(three, step, said):
    with pytest.raises(StereoLandmarkError, match=said) as refusal:
        step(three)
    assert '\n' not in str(refusal.value)


def test_detectors_run_and_stop():
    state = edits.show_kind(TeachingState(), PrimitiveKind.CORNER, shown=True)
    assert PrimitiveKind.CORNER in state.kinds
    assert edits.show_kind(state, PrimitiveKind.CORNER, shown=False).kinds == TeachingState().kinds
