"""Changes of a corridor change what they name and nothing else."""

import numpy as np
import pytest

from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.scene import CorridorScene
from scene_simulator.corridor.shapes import RoundLandmark, SquareLandmark
from scene_simulator.errors import SceneError


@pytest.fixture(scope='module')
def scene() -> CorridorScene:
    return corridor(CorridorDesign(4))


def test_every_landmark_is_the_outline_of_a_painted_shape(scene: CorridorScene) -> None:
    table = scene.table
    outlines = np.split(table.points, table.starts[1:-1])
    for landmark in scene.landmarks:
        if isinstance(landmark, SquareLandmark):
            corners = np.array(list(landmark.points_map().values()))
            assert any(len(o) == 4 and np.allclose(o, corners, atol=1e-9) for o in outlines), landmark.name
        else:
            assert isinstance(landmark, RoundLandmark)
            centre = landmark.points_map()[landmark.name]
            radii = [np.linalg.norm(o - centre, axis=1) for o in outlines if len(o) > 20]
            assert any(np.allclose(r, landmark.radius, atol=2e-5) for r in radii), landmark.name


def test_names_are_unique_and_points_are_in_the_corridor(scene: CorridorScene) -> None:
    names = [landmark.name for landmark in scene.landmarks]
    assert len(set(names)) == len(names)
    points = np.array(list(scene.points_map().values()))
    assert len(points) > 60
    assert (np.abs(points[:, 1]) < 2.4).all()
    assert ((points[:, 2] >= 0.0) & (points[:, 2] < 3.0)).all()


def test_moving_a_thing_moves_its_points_and_no_other(scene: CorridorScene) -> None:
    before, after = scene.points_map(), scene.move_object('cabinet', 0.1, -0.05).points_map()
    for name, point in before.items():
        own = name.startswith('cabinet')
        np.testing.assert_allclose(after[name] - point, (0.0, -0.1, -0.05) if own else 0.0, atol=1e-12)


def test_a_cover_hides_the_landmark_from_the_front(scene: CorridorScene) -> None:
    covered, meter = scene.cover_landmark('meter_2'), scene.points_map()['meter_2']
    sheet = covered.table.points[covered.table.starts[len(scene.table.starts) - 1] :][:4]
    assert (np.abs(sheet[:, 1:] - meter[1:]) > 0.1).all()
    assert (sheet[:, 0] < meter[0]).all()
    assert covered.points_map().keys() == scene.points_map().keys()


def test_unknown_names_are_refused_in_one_line(scene: CorridorScene) -> None:
    for change in (lambda: scene.move_object('sofa', 0.1, 0.0), lambda: scene.cover_landmark('sofa')):
        with pytest.raises(SceneError, match=r"no .*'sofa'.*meter_0") as caught:
            change()
        assert '\n' not in str(caught.value)
