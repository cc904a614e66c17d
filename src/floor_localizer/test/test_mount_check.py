"""Cameras that cannot see the floor are rejected."""

import math

import pytest

from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.localizer import check_mount
from shirube_core.geometry import CameraMount

DOWN = CameraMount()


@pytest.mark.parametrize('height', [0.0, -0.13])
def test_a_camera_that_is_not_above_the_floor_is_refused(height):
    with pytest.raises(FloorLocalizerError, match='camera_xyz: z is'):
        check_mount(CameraMount((0.0, 0.0, height), DOWN.rpy))


@pytest.mark.parametrize('rpy', [(0.0, 0.0, 0.0), (-math.pi / 2.0, 0.0, -math.pi / 2.0)])
def test_a_camera_that_looks_up_or_ahead_is_refused(rpy):
    with pytest.raises(FloorLocalizerError, match=r'camera_rpy: .* does not look at the floor'):
        check_mount(CameraMount((0.0, 0.0, 0.13), rpy))


@pytest.mark.parametrize('lean', [0.0, 0.5, -1.0])
def test_a_camera_that_leans_may_look_at_the_floor(lean):
    check_mount(CameraMount((0.1, 0.0, 0.13), (math.pi + lean, 0.0, -math.pi / 2.0)))
