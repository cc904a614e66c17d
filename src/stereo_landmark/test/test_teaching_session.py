"""Teaches a rendered wall without a page; the coordinates are those of the wall."""

from functools import partial

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from taught_wall import METERS, RIG, taught_place
from teaching_wall import images_of, meters_of, new_session, pairs_of_wall, session_with_meters

from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching import edits, teacher
from stereo_landmark.core.teaching.edits import state_from_place
from stereo_landmark.core.teaching.hints import NOT_DETECTED
from stereo_landmark.core.teaching.primitive_selection import Region
from stereo_landmark.core.teaching.teaching_session import TeachingSession
from stereo_landmark.page.pair_source import taught_pair
from stereo_landmark.page.place_saver import PlaceSaver
from stereo_landmark.page.snapshot import snapshot


def names(session):
    return list(session.state.target.primitives)


def report(session):
    return session.report(session.state.target)


def test_a_click_chooses_and_another_click_takes_out():
    session = new_session()
    meter = meters_of(session)[0]
    session.toggle(*meter)
    assert names(session) == ['ellipse 1']
    (chosen,) = (each for each in session.selectable() if session.selected_name(each.shape) == 'ellipse 1')
    assert (chosen.kind, chosen.number) == meter
    assert chosen.depth == pytest.approx(3.0 - RIG.mount.xyz[0], abs=0.05)
    session.toggle(*meter)
    assert names(session) == []
    session.undo()
    assert names(session) == ['ellipse 1']


def test_only_shown_kinds_within_the_region_are_selectable():
    session = new_session()
    session.apply(lambda state: edits.set_region(state, Region(0.0, 0.0, 187.0, 239.0)))
    assert session.selectable()
    assert all(each.shape.centre[0] < 187.0 for each in session.selectable())
    session.apply(lambda state: edits.show_kind(state, PrimitiveKind.ELLIPSE, shown=False))
    assert {each.kind for each in session.selectable()} == {PrimitiveKind.QUADRILATERAL}


def test_points_that_are_left_out_make_no_pose():
    session = session_with_meters()
    session.apply(lambda state: edits.set_points_used(state, ['ellipse 2/centre'], used=False))
    assert session.place().targets[0].points == ('ellipse 1/centre', 'ellipse 3/centre', 'ellipse 4/centre')
    assert 'ellipse 2/centre' not in report(session).fix.names


def test_chosen_primitives_outlive_a_change_of_the_image_processing_or_are_called_lost():
    session = session_with_meters()
    session.apply(lambda state: edits.set_processing(state, 'edges.filter_sigma', 1.2))
    assert not any(isinstance(each, str) for each in report(session).measured.values())
    session.apply(lambda state: edits.set_processing(state, 'edges.threshold', 200.0))
    assert set(report(session).measured.values()) == {NOT_DETECTED}
    with pytest.raises(StereoLandmarkError, match='ellipse 1: it is not detected with this image processing'):
        session.place()
    session.undo()
    assert len(session.place().targets[0].primitives) == len(METERS)


def test_what_was_found_is_found_again_in_the_same_image_only_where_it_is():
    session = session_with_meters(1)
    (meter,) = session.state.target.primitives.values()
    assert report(session).measured['ellipse 1'] != NOT_DETECTED
    session.apply(partial(edits.select_pair, pair=1))
    assert report(session).measured['ellipse 1'] == NOT_DETECTED
    assert session.selected_name(meter) is None


def test_a_chosen_primitive_is_looked_for_and_measured_once_however_often_the_page_asks(monkeypatch):
    calls = []
    for name in ('find_same', 'refine_pair'):
        work = getattr(teacher, name)
        monkeypatch.setattr(teacher, name, lambda *given, name=name, work=work: calls.append(name) or work(*given))
    session = session_with_meters(2)
    session.apply(lambda state: edits.set_processing(state, 'edges.filter_sigma', 1.2))
    calls.clear()
    first = snapshot(session, pairs_of_wall()), len(calls)
    assert (snapshot(session, pairs_of_wall()), len(calls)) == first


def test_a_place_is_taught_without_refused_shapes_which_one_edit_removes():
    session = session_with_meters()
    refused = next(each for each in session.selectable() if each.fault)
    session.toggle(refused.kind, refused.number)
    assert refused.fault in session.left_out[0]
    assert tuple(part.name for part in session.place().targets[0].primitives) == METER_NAMES
    session.remove_refused()
    assert tuple(session.state.target.primitives) == METER_NAMES


def test_images_of_another_size_are_refused():
    small = images_of(0)
    session = TeachingSession(lambda _: StereoImages(small.left[:200], small.right), RIG)
    words = 'the left image is 376 x 200 px, the calibration is for 376 x 240'
    with pytest.raises(StereoLandmarkError, match=words):
        session.selectable()


METER_NAMES = tuple(f'ellipse {k}' for k in range(1, len(METERS) + 1))
ACTIONS = st.lists(st.one_of(st.integers(0, 9), st.sampled_from(['undo', 'redo'])), max_size=30)


def new_history(first):
    return TeachingSession(images_of, RIG, first)


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(ACTIONS)
def test_undo_and_redo_walk_along_the_states(actions):
    """An action that changes nothing is no step."""
    history, past, future = new_history(-1), [-1], []
    for action in actions:
        if action == 'undo':
            history.undo()
            if len(past) > 1:
                future.append(past.pop())
        elif action == 'redo':
            history.redo()
            if future:
                past.append(future.pop())
        else:
            history.apply(lambda _, action=action: action)
            if action != past[-1]:
                past, future = [*past, action], []
        assert history.state == past[-1]
        assert history.can_undo == (len(past) > 1)
        assert history.can_redo == bool(future)


def test_a_movement_is_one_step_and_does_not_go_on_over_an_undo():
    history = new_history(9)
    for value, gesture in ((1, 'first'), (2, 'first'), (3, 'first'), (4, 'second'), (5, ''), (6, '')):
        history.apply(lambda _, value=value: value, gesture)
    states = []
    while history.can_undo:
        history.undo()
        states.append(history.state)
    assert states == [5, 4, 3, 9]
    for value in (1, 2):
        history.apply(lambda _, value=value: value, 'drag')
        history.undo()
    assert history.state == 9


def test_what_was_taught_is_taught_again_without_the_points_that_were_left_out(tmp_path):
    session = session_with_meters()
    session.apply(lambda state: edits.set_points_used(state, ['ellipse 3/centre'], used=False))
    place = session.place()
    source = taught_pair(PlaceSaver(tmp_path).save(place, session.images))
    assert source.rig == RIG
    assert np.array_equal(source.images(0).right, session.images.right)
    for taught in (place, taught_place()):
        again = TeachingSession(source.images, source.rig, state_from_place(taught)).place()
        for name in ('name', 'processing', 'T_map_place'):
            assert getattr(again, name) == getattr(taught, name)
        assert [target.points for target in again.targets] == [target.points for target in taught.targets]
        assert again.coordinates.names == taught.coordinates.names
        assert again.coordinates.positions == pytest.approx(taught.coordinates.positions, abs=1e-6)
