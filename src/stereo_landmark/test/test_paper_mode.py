"""The paper mode of the localizer, and targets with two points, end to end on rendered walls."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_wall import Disc, Plate, Wall, from_left, look, teach_view, view_of
from meter_walls import ALL, row_of_meters
from place_scenes import RIG, errors_of

from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.core.place import place_locator
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind, primitive_size
from stereo_landmark.core.procedure import paper_search, procedure_tree
from stereo_landmark.core.procedure.procedure_tree import ProcedureTree
from stereo_landmark.core.procedure.stereo_view import detect_scene
from stereo_landmark.core.settings import EdgeSettings, LandmarkSettings, SearchSettings
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

UNEVEN = Wall(row_of_meters(0.6 - np.cumsum([0.0, 0.28, 0.31, 0.26, 0.3])))
SQUARES = Wall(tuple(Plate(y, 0.75, 0.17, 0.2, 60.0) for y in (0.6, 0.32, 0.01, -0.25, -0.55)))
STATE = np.array([0.15, -0.1, 0.0, 0.06, 0.0, 0.0])
PAPER = LandmarkSettings(mode='paper')


def teach(wall, kind=PrimitiveKind.ELLIPSE, count=4):
    """Teach the left ones of the primitives of a kind, leftmost surest."""
    view = view_of(wall, np.zeros(6))
    # Gaps between meters and rows of them are quadrilaterals, too.
    parts = [each for each in from_left(view, kind) if each.polarity < 0 and 18.0 < primitive_size(each) < 35.0]
    assert len(parts) == 5
    return teach_view(view, {f'part {i}': parts[i] for i in range(count)})


def locate(place, images, settings=PAPER):
    return LandmarkLocalizer([place], settings).locate(*images)


def check(answer, state=STATE, sigmas=4.0):
    assert isinstance(answer, LandmarkFix)
    fix = answer.displacement
    errors = errors_of(fix.T_place_base, fix.height, state)
    assert (np.abs(errors) < sigmas * np.sqrt(np.diag(fix.covariance))).all()


@pytest.fixture(scope='module')
def place():
    return teach(UNEVEN)


@pytest.mark.parametrize(('wall', 'kind'), [(UNEVEN, PrimitiveKind.ELLIPSE), (SQUARES, PrimitiveKind.QUADRILATERAL)])
@pytest.mark.parametrize('hidden', [None, 0, 2])
def test_four_of_five_meters_are_found_though_one_is_hidden(wall, kind, hidden):
    """The paper's experiment (section 5) has square ones."""
    place = teach(wall, kind)
    answer = locate(place, look(wall if hidden is None else wall.without(hidden), STATE))
    check(answer)
    (detection,) = answer.detections
    expected = [f'target/part {i}' for i in range(4) if i != hidden]
    assert list(detection.found) == expected


def test_paths_begin_with_the_surest_primitives_until_one_succeeds(place, monkeypatch):
    """And with the next one, which may show rivals; a path fails when its distances are not the taught ones."""
    firsts = []

    class Recorded(ProcedureTree):
        def search(self, first):
            firsts.append(first)
            return super().search(first)

    monkeypatch.setattr(paper_search, 'ProcedureTree', Recorded)
    locate(place, look(UNEVEN, STATE))
    assert firsts == [0, 0, 1, 1]
    firsts.clear()
    locate(place, look(UNEVEN.without(0), STATE))
    assert firsts == [0, 0, 1, 1, 2, 2]


def test_an_even_row_is_ambiguous_because_surroundings_are_not_used():
    answer = locate(teach(ALL), look(ALL, STATE))
    assert answer.reason == 'ambiguous: several poses match'
    assert isinstance(locate(teach(ALL), look(ALL, STATE), LandmarkSettings()), LandmarkFix)


def test_a_robot_farther_away_than_it_may_be_is_not_found(place):
    images = look(UNEVEN, STATE)
    for limits in ({'distance_max': 0.1}, {'yaw_max': 0.03}):
        near = replace(PAPER, search=SearchSettings(**limits))
        assert locate(place, images, near).reason == 'no similar shapes in view'


def test_the_closed_form_needs_no_reprojection_fit(place, monkeypatch):
    """The paper's equation with its own inliers: a moved meter is an outlier by its distances (3.4, end)."""
    monkeypatch.setattr(place_locator, 'fit_reprojection', None)
    meters = list(UNEVEN.things)
    meters[1] = replace(meters[1], y=meters[1].y + 0.03)
    answer = locate(place, look(Wall(tuple(meters)), STATE))
    check(answer)
    assert 'target/part 1/centre' not in answer.displacement.names
    assert len(answer.displacement.names) == 3


def test_only_the_window_of_the_target_is_processed(place, monkeypatch):
    """What is above and below the meters does not matter, whatever it is."""
    sizes = []

    def detect(image, *given):
        sizes.append(image.shape)
        return detect_scene(image, *given)

    monkeypatch.setattr(procedure_tree, 'detect_scene', detect)
    images = look(UNEVEN, STATE)
    for image in images:
        image[400:] = np.random.default_rng(1).integers(0, 255, image[400:].shape)
    check(locate(place, images))
    assert len(sizes) == 2
    assert max(height for height, _ in sizes) < 300


@pytest.mark.parametrize('mode', ['likelihood', 'paper'])
def test_a_target_has_image_processing_of_its_own(mode):
    """The threshold of the place does not detect a faint sign; that of the target does."""
    shapes = ((0.4, 0.8, 0.3, 0.2), (-0.1, 0.9, 0.2, 0.3), (-0.5, 0.7, 0.25, 0.2))
    faint = Wall(tuple(Plate(*shape, 137.0) for shape in shapes))
    own = ImageProcessing(edges=EdgeSettings(threshold=2.0))
    view = view_of(faint, np.zeros(6), noise=0.3)
    assert not from_left(view, PrimitiveKind.QUADRILATERAL)
    teacher = Teacher(view, ImageProcessing())
    parts = from_left(teacher.with_processing(own).view, PrimitiveKind.QUADRILATERAL)
    chosen = {f'sign {i}': part for i, part in enumerate(parts[:3])}
    place = teacher.teach('faint', [TargetSelection('signs', chosen, processing=own)])
    assert place.targets[0].processing == own
    check(locate(place, look(faint, STATE, noise=0.3), LandmarkSettings(mode=mode)))


TWO = Wall((Disc(0.45, 0.9, 0.1, 50.0), Disc(-0.35, 0.7, 0.08, 60.0), Plate(1.1, 0.8, 0.2, 0.3, 90.0)))
LINED = Wall((Disc(0.4, 0.75, 0.1, 50.0), Plate(-0.3, 0.75, 0.08, 0.9, 60.0)))


@pytest.mark.parametrize('mode', ['likelihood', 'paper'])
@pytest.mark.parametrize('wall', [TWO, LINED])
def test_two_circles_or_a_circle_with_parallel_lines_are_enough(wall, mode):
    """Section 3.1: two points or more."""
    view = view_of(wall, np.zeros(6))
    circles = from_left(view)
    parts = {f'circle {i}': circle for i, circle in enumerate(circles)}
    if wall is LINED:
        lines = from_left(view, PrimitiveKind.PARALLEL_LINES)
        parts['lines'] = max(lines, key=lambda each: each.length)
    answer = locate(teach_view(view, parts), look(wall, STATE), LandmarkSettings(mode=mode))
    check(answer)
    assert len(answer.displacement.names) == 2


def test_the_meter_of_figure_4_needs_a_second_one_beside_it():
    """The centres of one meter's circle and lines are above each other or coincide: the yaw is not determined."""
    bracket, disc = Plate(0.0, 0.55, 0.06, 0.22, 60.0), Disc(0.0, 0.75, 0.1, 50.0)
    meters = [replace(shape, y=y) for y in (0.3, -0.2) for shape in (bracket, disc)]
    view = view_of(Wall(tuple(meters)), np.zeros(6))
    lines = [each for each in from_left(view, PrimitiveKind.PARALLEL_LINES) if abs(each.tilt) > 1.0]
    parts = {}
    for i, circle in enumerate(from_left(view)):
        below = circle.centre + np.array([0.0, 0.2 / 3.0 * RIG.left.fy])
        parts[f'circle {i}'] = circle
        parts[f'lines {i}'] = min(lines, key=lambda each: np.hypot(*(each.centre - below)))
    images = look(Wall(tuple(meters)), STATE)
    for settings in (LandmarkSettings(), PAPER):
        check(locate(teach_view(view, parts), images, settings))
    one = {name: parts[name] for name in ('circle 0', 'lines 0')}
    assert not isinstance(locate(teach_view(view, one), images), LandmarkFix)
