"""Hints come where choices are weak, and only there."""

import pytest
from teaching_wall import new_session, session_with_meters
from test_target_search import ALONE, METERS
from drawn_wall import look
from place_scenes import RIG

from stereo_landmark.core.procedure.primitive import Kind
from stereo_landmark.core.teaching import edits
from stereo_landmark.core.teaching.procedure_check import Outcome
from stereo_landmark.core.teaching.teaching_session import StereoImages, TeachingSession
from stereo_landmark.core.teaching.weak_choices import Weight, weak_procedure


def hints(session):
    return session.report(session.state.target).hints


def test_a_good_target_has_no_hints_and_is_found_with_any_part_hidden():
    session = session_with_meters()
    assert hints(session) == []
    trials = session.check(0)
    assert {trial.outcome for trial in trials} == {Outcome.FOUND}
    assert [trial.hidden for trial in trials][:2] == [(), ('ellipse 1',)]
    assert ('ellipse 1', 'ellipse 2') in [trial.hidden for trial in trials]
    assert list(weak_procedure('target_1', trials)) == []


@pytest.mark.parametrize(
    ('count', 'said'), [(0, 'nothing is chosen'), (1, 'too few points'), (2, 'too few points')]
)
def test_too_few_is_no_place(count, said):
    (hint,) = (hint for hint in hints(session_with_meters(count)) if hint.weight is Weight.STOP)
    assert said in hint.text


def test_points_close_together_promise_little():
    session = new_session()
    plates = [each for each in session.found() if each.kind is Kind.QUADRILATERAL and each.depth is not None]
    small = min(plates, key=lambda each: float(abs(each.shape.corner_vectors).max()))
    session.toggle(small.kind, small.number)
    texts = [hint.text for hint in hints(session)]
    assert any('are to be expected' in text or 'too uncertain' in text for text in texts)
    assert not any('are to be expected' in hint.text for hint in hints(session_with_meters()))


def test_identical_meters_alone_are_ambiguous_when_one_at_the_end_is_hidden():
    left, right = look(ALONE, (0.0,) * 6, RIG)
    session = TeachingSession(lambda _: StereoImages(left, right), RIG)
    meters = sorted(
        (each for each in session.found() if each.kind is Kind.ELLIPSE), key=lambda each: each.shape.centre[0]
    )
    assert len(meters) == len(METERS)
    for meter in meters[:4]:
        session.toggle(meter.kind, meter.number)
    trials = {trial.hidden: trial for trial in session.check(0)}
    assert trials[()].outcome is Outcome.FOUND
    assert trials['ellipse 1',].outcome is Outcome.AMBIGUOUS
    weak = list(weak_procedure('target_1', list(trials.values())))
    assert any(hint.about == 'ellipse 1' and 'several places' in hint.text for hint in weak)
    assert {hint.weight for hint in weak} == {Weight.WEAK}


def test_a_primitive_at_the_border_should_not_be_the_first():
    session = session_with_meters()
    for hint in hints(session):
        assert 'border' not in hint.text
    plates = [each for each in session.found() if each.kind is Kind.QUADRILATERAL and each.depth is not None]
    outer = min(plates, key=lambda each: each.shape.corners[:, 0].min())
    session.toggle(outer.kind, outer.number)
    name = session.state.target.primitives[-1].name
    session.do(lambda state: edits.move(state, name, 0))
    assert any(hint.about == name and 'border' in hint.text for hint in hints(session))
