"""Lens flares: position and brightness."""

from __future__ import annotations

import numpy as np
import pytest

from scene_simulator.blooming import SHARP
from scene_simulator.camera_motion import CameraPose, camera_pose
from scene_simulator.ceiling_camera import UPWARD_MOUNT, CeilingCamera
from scene_simulator.ceiling_lamp import CeilingLamp
from scene_simulator.ceiling_lens import CeilingLens, LensFlare
from scene_simulator.ceiling_room import CeilingRoom
from scene_simulator.lamp_shape import Disc, Rectangle
from scene_simulator.shutter import Shutter
from shirube_core.geometry import SE2, PinholeCamera
from shirube_core.waveform import waveform_from_steps

CAMERA = PinholeCamera(320, 240, 320.0, 320.0, 159.5, 119.5)
GHOST = LensFlare(scale=-0.5, strength=0.1, radius=8.0)
BLINK = waveform_from_steps([1e-3, 1e-3], [1.0, 0.0])


def resting(_: float) -> CameraPose:
    return camera_pose(SE2(0.0, 0.0, 0.0), UPWARD_MOUNT)


def flare_light(lamp: CeilingLamp, shutter: Shutter, stamp: float = 0.0) -> np.ndarray:
    with_ghost, without = (
        CeilingCamera(CAMERA, shutter, CeilingLens(0.0, blooming=SHARP, flares=flares)).light(
            CeilingRoom((lamp,)), resting, stamp
        )
        for flares in ((GHOST,), ())
    )
    return with_ghost - without


def test_a_flare_is_opposite_the_principal_point() -> None:
    light = flare_light(CeilingLamp((0.4, 0.6, 2.5), Disc(0.05)), Shutter())
    v, u = np.mgrid[:240, :320]
    middle = np.array([(light * u).sum(), (light * v).sum()]) / light.sum()
    lamp = np.array([320.0 * 0.6 / 2.5, -320.0 * 0.4 / 2.5])
    np.testing.assert_allclose(middle, [159.5, 119.5] - 0.5 * lamp, atol=0.02)
    assert light.max() == pytest.approx(0.1 * 2000.0 * 0.5e-3, rel=1e-2)


def test_a_flare_has_the_light_of_its_own_rows() -> None:
    shutter = Shutter(50e-6, 40e-6)
    steady = flare_light(CeilingLamp((-0.3, 0.2, 2.5), Disc(0.05)), shutter)
    blinking = flare_light(CeilingLamp((-0.3, 0.2, 2.5), Disc(0.05), BLINK), shutter)
    rows = np.flatnonzero(steady.max(axis=1) > 0.005)
    levels = BLINK.mean_levels(40e-6 * rows, 40e-6 * rows + 50e-6)[:, 0]
    np.testing.assert_allclose(blinking[rows], levels[:, None] * steady[rows], atol=1e-6)


def test_the_flare_of_a_lamp_outside_the_image_may_be_inside() -> None:
    outside = CeilingLamp((0.0, 1.4, 2.5), Disc(0.05))
    assert flare_light(outside, Shutter()).max() > 0.05
    assert flare_light(CeilingLamp((0.0, 40.0, 2.5), Disc(0.05)), Shutter()).max() == 0.0


def test_a_window_next_to_the_camera_may_extend_from_behind_it_into_view() -> None:
    window = CeilingLamp((0.0, 1.0, -0.2), Rectangle(1.0, 6.0), rpy=(np.pi / 2.0, 0.0, 0.0), brightness=500.0)
    taken = CeilingCamera(CAMERA, Shutter(2e-3), CeilingLens(0.0, blooming=SHARP))
    turning = lambda time: camera_pose(SE2(0.0, 0.0, 3.0 * time), UPWARD_MOUNT)  # noqa: E731
    light = taken.light(CeilingRoom((window,)), turning, 0.0)
    # The wall at 1 m is seen where it is up to 2.8 m high, half a metre to each side.
    u = 159.5 + 320.0 * 1.0 / np.array([3.4, 2.4, 2.2])
    v = 119.5 + 320.0 * 0.2 / np.array([3.4, 2.4, 2.2])
    np.testing.assert_allclose(light[v.astype(int), u.astype(int)], [0.0, 1.0, 1.0], atol=0.01)
