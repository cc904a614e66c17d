"""Hints are given for weak selections only."""

import numpy as np
import pytest
from drawn_wall import Plate, Wall, look
from meter_walls import ALL, ALONE
from place_scenes import RIG
from teaching_wall import session_with_meters

from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.core.teaching import edits
from stereo_landmark.core.teaching.hints import Severity
from stereo_landmark.core.teaching.procedure_check import Outcome, check_trials
from stereo_landmark.core.teaching.teaching_session import TeachingSession


def hints(session):
    return session.report(session.state.target).hints


def test_a_good_target_has_no_hints_and_is_found_with_any_part_hidden():
    session = session_with_meters()
    assert hints(session) == []
    trials = session.check(0)
    assert {trial.outcome for trial in trials} == {Outcome.FOUND}
    assert [trial.hidden for trial in trials][:2] == [(), ('ellipse 1',)]
    assert ('ellipse 1', 'ellipse 2') in [trial.hidden for trial in trials]
    assert list(check_trials('target_1', trials)) == []


@pytest.mark.parametrize(('count', 'said'), [(0, 'no shape is selected'), (1, 'too few points')])
def test_too_few_is_no_place(count, said):
    (hint,) = (hint for hint in hints(session_with_meters(count)) if hint.severity is Severity.STOP)
    assert said in hint.text


def large_session(wall):
    """Return a session in front of a wall with large cameras."""
    images = StereoImages(*look(wall, (0.0,) * 6, RIG))
    return TeachingSession(lambda _: images, RIG)


def choose(session, y, z, kind=PrimitiveKind.QUADRILATERAL):
    """Select the primitive with its centre at this position on the wall [m], and return its name."""
    ((u, v, _, _),) = RIG.project((np.array([[3.0, y, z]]) - RIG.mount.xyz) @ RIG.mount.rotation)
    shown = [each for each in session.selectable() if each.kind is kind]
    nearest = min(shown, key=lambda each: float(np.hypot(*(each.shape.centre - [u, v]))))
    session.toggle(kind, nearest.number)
    return list(session.state.target.primitives)[-1]


def test_points_close_together_promise_little():
    session = large_session(ALL)
    choose(session, -0.75, 0.95)
    texts = [hint.text for hint in hints(session)]
    assert any(text.startswith('too few shapes: 1') for text in texts)
    assert any('horizontal extent is 0.20 m' in text for text in texts)
    choose(session, 0.9, 0.75)
    assert not any('horizontal extent' in hint.text for hint in hints(session))


def test_identical_meters_alone_are_ambiguous_when_one_at_the_end_is_hidden():
    session = large_session(ALONE)
    for meter in ALONE.things[:4]:
        choose(session, meter.y, meter.z, PrimitiveKind.ELLIPSE)
    trials = {trial.hidden: trial for trial in session.check(0)}
    assert trials[()].outcome is Outcome.FOUND
    assert trials['ellipse 1',].outcome is Outcome.AMBIGUOUS
    weak = list(check_trials('target_1', list(trials.values())))
    assert any(hint.about == 'ellipse 1' and 'could be confused' in hint.text for hint in weak)
    assert Severity.STOP not in {hint.severity for hint in weak}


def test_a_primitive_at_the_border_should_not_be_the_first():
    session = large_session(Wall((*ALL.things, Plate(1.25, 0.75, 0.12, 0.3, 200.0))))
    inner, outer = choose(session, -0.75, 0.95), choose(session, 1.25, 0.75)
    for first, about in ((None, []), (outer, [outer]), (inner, [])):
        if first is not None:
            session.apply(lambda state, first=first: edits.move_primitive(state, first, 0))
        assert [hint.about for hint in hints(session) if 'border' in hint.text] == about
