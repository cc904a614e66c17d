import math

import numpy as np
import pytest
from drawn_wall import Disc, Plate, Wall, view_of

from stereo_landmark.core.landmark_fix import TargetDetection
from stereo_landmark.core.place.reprojection import reproject
from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.procedure.prediction import centre_correction, wall_normal
from stereo_landmark.core.procedure.stereo_view import ImageProcessing, StereoView
from stereo_landmark.core.procedure.target_search import TargetSearch
from stereo_landmark.core.teaching.teaching_state import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher


def test_the_wall_is_the_line_with_most_things_on_it():
    rng = np.random.default_rng(1)
    for angle in (-0.7, -0.2, 0.0, 0.5):
        along = np.array([-math.sin(angle), math.cos(angle)])
        wall = np.array([3.0, 0.3]) + np.linspace(-0.6, 0.6, 7)[:, None] * along
        heights = rng.uniform(0.0, 1.0, (7, 1))
        things = np.vstack([np.hstack([wall, heights]), [[2.0, 0.5, 0.3], [1.5, -0.8, 1.0]]])
        normal = wall_normal(things[3], things)
        assert normal == pytest.approx([-math.cos(angle), -math.sin(angle), 0.0], abs=1e-6)


def test_a_thing_alone_faces_the_robot():
    position = np.array([3.0, 4.0, 1.0])
    assert wall_normal(position, position[None]) == pytest.approx([-0.6, -0.8, 0.0])


def test_centres_of_circles_are_measured_where_they_were_taught():
    """From a viewpoint 15 degrees to the side, the ellipse centre of a large disc is biased by half a pixel."""
    wall = Wall((Disc(0.3, 0.7, 0.2, 60.0), Plate(-0.4, 0.7, 0.4, 0.3, 220.0)))
    view = view_of(wall, np.zeros(6), tuple(PrimitiveKind), noise=0.5)
    seen = view.left.kinds
    parts = {
        'dial': seen[PrimitiveKind.ELLIPSE].primitives[0],
        'panel': seen[PrimitiveKind.QUADRILATERAL].primitives[0],
    }
    place = Teacher(view, ImageProcessing()).teach('wall', [TargetSelection('target', parts)])
    assert place.targets[0].primitives[0].normal == pytest.approx([-1.0, 0.0, 0.0], abs=0.02)
    state = np.array([0.3, -0.5, 0.0, 0.26, 0.0, 0.0])
    found = TargetSearch(place).search(place.targets[0], view_of(wall, state, place.kinds, noise=0.5))
    assert isinstance(found, TargetDetection)
    seen = found.points.pixels[found.points.names.index('target/dial/centre')]
    true = reproject(state, np.array([[3.0, 0.3, 0.7]]), place.rig).pixels[0]
    assert seen == pytest.approx(true, abs=0.08)
    moved = centre_correction(
        place.targets[0].primitives[0], state[:4], StereoView(view.left, view.right, place.rig)
    )
    assert np.hypot(*moved[:2]) > 0.4
