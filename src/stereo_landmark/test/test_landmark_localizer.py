from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from drawn_wall import Disc, Plate, Wall, detect_view, from_left, look, teach_view, view_of
from scipy.spatial.transform import Rotation
from stereo_calibrations import RealPairs

from shirube_core.geometry import SE2, CameraMount, wrap_angle
from stereo_landmark.core import landmark_localizer
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer, NoLandmarkFix, PlacePrior
from stereo_landmark.core.pair.camera_pair import Rectifier, stereo_rig
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import detect_scene
from stereo_landmark.core.settings import LandmarkSettings, SearchSettings
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.teacher import Teacher

PANELS = Wall((Plate(0.35, 0.7, 0.4, 0.3, 80.0), Plate(-0.3, 0.75, 0.3, 0.4, 220.0), Disc(-0.75, 0.6, 0.08, 60.0)))
SIGNS = Wall((Plate(0.1, 0.8, 0.7, 0.2, 60.0), Disc(0.7, 0.6, 0.12, 200.0), Disc(-0.6, 0.6, 0.1, 230.0)))
STATE = np.array([0.2, -0.1, 0.0, 0.08, 0.0, 0.0])


def taught(wall, name, T_map_place=None):
    view = view_of(wall, np.zeros(6))
    parts = (*from_left(view, PrimitiveKind.QUADRILATERAL), *from_left(view))
    return teach_view(view, {f'part {i}': part for i, part in enumerate(parts)}, name, T_map_place)


def with_points(place, count):
    """Return a place of which only some points are used for the pose."""
    (target,) = place.targets
    return replace(place, targets=(replace(target, points=target.points[:count]),))


@pytest.fixture(scope='module')
def places():
    return [taught(PANELS, 'panels', SE2(5.0, 2.0, 1.0)), taught(SIGNS, 'signs')]


@pytest.fixture(scope='module')
def images():
    return look(PANELS, STATE)


def test_the_place_and_the_displacement_are_found(places, images):
    fix = LandmarkLocalizer(places).locate(*images)
    assert fix.place.name == 'panels'
    pose = fix.displacement.T_place_base
    assert [pose.x, pose.y, pose.yaw] == pytest.approx(STATE[[0, 1, 3]].tolist(), abs=0.004)
    expected = SE2(5.0, 2.0, 1.0) @ SE2(*STATE[[0, 1, 3]])
    assert fix.T_map_base.distance_to(expected) < 0.006


def test_another_place_is_tried_when_the_robot_is_not_where_it_should_be(places, images):
    fix = LandmarkLocalizer(places).locate(*images, prior=PlacePrior('signs'))
    assert fix.place.name == 'panels'
    answer = LandmarkLocalizer(places[1:]).locate(*images)
    assert answer.detail.startswith('place signs: target: ')


def test_a_target_that_is_found_but_gives_no_points_is_too_few(places, images):
    """Old places may have no points, and in a view none may be measurable."""
    answer = LandmarkLocalizer([with_points(places[0], 0)]).locate(*images)
    assert answer.reason == 'too few points'


def test_two_similar_places_are_ambiguous(places, images):
    localizer = LandmarkLocalizer([places[0], replace(places[0], name='twin')])
    assert localizer.locate(*images).reason == 'ambiguous: several places match'
    assert isinstance(localizer.locate(*images, prior=PlacePrior('twin')), LandmarkFix)


def test_the_failure_reason_is_that_of_the_place_nearest_to_a_fix(places, images):
    """The signs are first, but all panels are detected; only their points are too few."""
    panels = with_points(places[0], 1)
    for taught in ([places[1], panels], [panels, places[1]]):
        answer = LandmarkLocalizer(taught).locate(*images)
        assert answer.detail.startswith('place panels: ')


def test_images_are_looked_at_once_for_places_of_one_image_processing(places, images, monkeypatch):
    looked_at = []
    monkeypatch.setattr(
        landmark_localizer, 'detect_scene', lambda *given: looked_at.append(given) or detect_scene(*given)
    )
    halls = [replace(places[1], name=f'hall {number}') for number in range(3)]
    assert isinstance(LandmarkLocalizer(halls).locate(*images, prior=PlacePrior('hall 1')), NoLandmarkFix)
    assert len(looked_at) == 2
    processing = places[1].processing
    other = replace(processing, edges=replace(processing.edges, threshold=7.0))
    halls.append(replace(places[1], name='other', processing=other))
    LandmarkLocalizer(halls).locate(*images)
    assert len(looked_at) == 6


@pytest.mark.parametrize(
    ('distance_max', 'yaw_max', 'expected'), [(0.05, 0.02, NoLandmarkFix), (0.25, 0.1, LandmarkFix)]
)
def test_a_robot_farther_away_than_it_may_be_is_not_found(places, images, distance_max, yaw_max, expected):
    settings = LandmarkSettings(search=SearchSettings(distance_max=distance_max, yaw_max=yaw_max))
    assert isinstance(LandmarkLocalizer(places, settings).locate(*images), expected)


def test_places_must_have_names_of_their_own(places):
    with pytest.raises(StereoLandmarkError, match='two places are called panels'):
        LandmarkLocalizer([places[0], places[0]])
    with pytest.raises(StereoLandmarkError, match='no taught place'):
        LandmarkLocalizer([])


def test_images_of_other_cameras_are_refused(places, images):
    words = 'right image is 376 x 480 px, the calibration is for 752 x 480 px'
    with pytest.raises(StereoLandmarkError, match=words):
        LandmarkLocalizer(places).locate(images[0], images[1][:, ::2].copy())


R_BODY_BASE = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
"""The body's x is up, y right and z ahead."""
PRIMITIVES, APART, BORDER, SIZE = 16, 25.0, 45.0, np.array([752, 480])


class Room:
    """Teach and repeat pair: images, true position [m] and roll, pitch, yaw [rad] of the base in the room."""

    def __init__(self):
        pairs = RealPairs()
        T = pairs.T_body_cameras[0]
        R = R_BODY_BASE.T @ T[:3, :3] @ np.array(pairs.calibrations[0].rotation).reshape(3, 3).T
        xyz, rpy = R_BODY_BASE.T @ T[:3, 3], Rotation.from_matrix(R).as_euler('xyz')
        self.rig = stereo_rig(*pairs.calibrations, CameraMount(tuple(xyz.tolist()), tuple(rpy.tolist())))
        self.images, self.positions, self.rpy = {}, {}, {}
        for frame in pairs.truth['frames']:
            w, x, y, z = frame['q_wxyz']
            role, raw = frame['role'], pairs.images(frame['role'])
            R_room_base = Rotation.from_quat([x, y, z, w]).as_matrix() @ R_BODY_BASE
            self.rpy[role] = Rotation.from_matrix(R_room_base).as_euler('xyz')
            self.positions[role] = np.array(frame['p'])
            self.images[role] = [Rectifier(each).rectify(i) for each, i in zip(pairs.calibrations, raw)]

    def view(self, role):
        return replace(detect_view(self.images[role], self.rig), tilt=tuple(self.rpy[role][:2]))

    def error(self, taught, now, fix):
        """Return the error of a displacement [m, rad]."""
        yaw = self.rpy[taught][2]
        shift = Rotation.from_euler('z', -yaw).apply(self.positions[now] - self.positions[taught])
        pose = fix.T_place_base
        turn = wrap_angle(pose.yaw - (self.rpy[now][2] - yaw))
        return np.linalg.norm([pose.x, pose.y, fix.height] - shift), abs(turn)


def drawn(teacher, primitives, rng):
    """Return random measurable primitives inside both images with a minimum spacing, by name."""
    chosen = []
    for i in rng.permutation(len(primitives)):
        primitive = primitives[i]
        inside = (primitive.centre > BORDER).all() and (primitive.centre < SIZE - BORDER).all()
        is_apart = all(np.hypot(*(primitive.centre - each.centre)) >= APART for each in chosen)
        if inside and is_apart and len(chosen) < PRIMITIVES:
            with suppress(StereoLandmarkError):
                teacher.measure(primitive)
                chosen.append(primitive)
    return {f'part {i}': each for i, each in enumerate(chosen)}


@pytest.mark.parametrize(('taught', 'now', 'seed'), [('teach', 'repeat', 0), ('repeat', 'teach', 1)])
def test_a_real_room_is_found_again_though_its_squares_repeat(taught, now, seed):
    """The pairs are 0.3 m and 15° apart; a board has 36 square tags."""
    room = Room()
    view = room.view(taught)
    squares = view.left.kinds[PrimitiveKind.QUADRILATERAL].primitives
    parts = drawn(Teacher(view, ImageProcessing()), squares, np.random.default_rng(seed))
    answer = LandmarkLocalizer([teach_view(view, parts)]).locate(*room.images[now], tuple(room.rpy[now][:2]))
    position, turn = room.error(taught, now, answer.displacement)
    assert position < 0.015
    assert turn < np.radians(0.5)
