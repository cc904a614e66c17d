"""A tag is seen as it was printed."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from scene_simulator.blooming import SHARP
from scene_simulator.camera_motion import camera_pose
from scene_simulator.ceiling_camera import UPWARD_MOUNT, CeilingCamera
from scene_simulator.ceiling_lens import CeilingLens
from scene_simulator.ceiling_room import CeilingRoom
from scene_simulator.errors import SceneError
from scene_simulator.gain_sensor import GainSensor
from scene_simulator.printed_tag import printed_tag
from shirube_core.geometry import SE2, PinholeCamera

EYE = CeilingCamera(
    PinholeCamera(200, 160, 636.4, 636.4, 99.5, 79.5),
    lens=CeilingLens(0.0, blooming=SHARP),
    sensor=GainSensor(black_level=0.0),
)
CELL = 10.0 * 2.5 / 636.4
"""Ten pixels wide at 2.5 m."""


def seen(cells: np.ndarray) -> np.ndarray:
    room = CeilingRoom(printed_tag(cells, CELL, (0.0, 0.0, 2.5), EYE.brightness_for(0.8)))
    return EYE.photograph(room, lambda _: camera_pose(SE2(0.0, 0.0, 0.0), UPWARD_MOUNT), 0.0).image


def test_every_cell_is_seen_in_its_place() -> None:
    cells = np.random.default_rng(4).random((8, 10)) < 0.5
    image = seen(cells)
    # Upper edge ahead, so the cells are in the image as in the array; it is 10 px to the middle of the next.
    middles = image[np.ix_(45 + 10 * np.arange(8), 55 + 10 * np.arange(10))]
    np.testing.assert_allclose(middles, 204.0 * cells, atol=1.0)


def test_white_paper_has_no_seams() -> None:
    image = seen(np.ones((8, 10), dtype=bool))
    inside = image[45:115, 55:145]
    np.testing.assert_allclose(inside, 204.0, atol=1.0)


def test_a_detector_reads_it() -> None:
    aruco = getattr(cv2, 'aruco', None)
    if aruco is None:
        pytest.skip('this OpenCV has no aruco module')
    dictionary = aruco.getPredefinedDictionary(aruco.DICT_4X4_50)
    cells = np.pad(aruco.generateImageMarker(dictionary, 17, 6) > 127, 1, constant_values=True)
    corners, ids, _ = aruco.ArucoDetector(dictionary).detectMarkers(seen(cells))
    assert np.ravel(ids).tolist() == [17]
    expected = np.array([(70.0, 50.0), (129.0, 50.0), (129.0, 109.0), (70.0, 109.0)])
    np.testing.assert_allclose(np.reshape(corners[0], (4, 2)), expected, atol=1.0)


def test_what_is_no_tag_is_refused() -> None:
    for cells, cell in ((np.ones(4), 0.01), (np.ones((4, 4)), 0.0), (np.empty((0, 4)), 0.01)):
        with pytest.raises(SceneError, match='tag'):
            printed_tag(cells, cell, (0.0, 0.0, 2.5), 1.0)
