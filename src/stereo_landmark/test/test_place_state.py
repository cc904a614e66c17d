"""A reopened place equals the saved place."""

import numpy as np
import pytest
from taught_wall import RIG, taught_place
from teaching_wall import images_of, session_with_meters

from stereo_landmark.core.teaching import edits
from stereo_landmark.core.teaching.teaching_state import state_from_place
from stereo_landmark.core.teaching.teaching_session import TeachingSession
from stereo_landmark.page.pair_source import taught_pair
from stereo_landmark.page.place_saver import PlaceSaver


def assert_same(place, other):
    assert (place.name, place.processing, place.T_map_place) == (
        other.name,
        other.processing,
        other.T_map_place,
    )
    assert [target.points for target in place.targets] == [target.points for target in other.targets]
    assert place.coordinates.names == other.coordinates.names
    assert place.coordinates.positions == pytest.approx(other.coordinates.positions, abs=1e-6)


def test_what_was_taught_is_taught_again():
    place = taught_place()
    again = TeachingSession(images_of, RIG, state_from_place(place))
    assert_same(again.place(), place)


def test_points_that_were_left_out_stay_so(tmp_path):
    session = session_with_meters()
    session.apply(lambda state: edits.set_points_used(state, ['ellipse 3/centre'], used=False))
    path = PlaceSaver(tmp_path).save(session.place(), session.images)
    source = taught_pair(path)
    assert source.rig == RIG
    assert np.array_equal(source.images(0).right, session.images.right)
    again = TeachingSession(source.images, source.rig, state_from_place(session.place()))
    assert again.state.target.excluded_points == {'ellipse 3/centre'}
    assert_same(again.place(), session.place())
