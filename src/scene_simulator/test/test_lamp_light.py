"""True lamp projections against a projection written out by hand."""

import math

import cv2
import numpy as np
import pytest

from scene_simulator.ceiling.camera import UPWARD_MOUNT, CeilingCamera
from scene_simulator.ceiling.lamp import CeilingLamp, Disc, Rectangle
from scene_simulator.ceiling.lamp_light import LampProjection, project_lamp
from scene_simulator.ceiling.lens import SHARP, CeilingLens
from scene_simulator.ceiling.room import CeilingRoom
from scene_simulator.imaging.exposure import CameraMotion, CameraPose, Shutter, camera_pose
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

PAPER = PinholeCamera(1280, 1024, 636.4, 636.4, 639.5, 511.5)
BENT = PinholeCamera(1280, 1024, 640.0, 636.0, 650.0, 500.0, (-0.12, 0.02, 0.0008, -0.0005, 0.0))
MOUNT = CameraMount((0.05, 0.02, 0.3), (0.02, -0.03, math.pi / 2.0 + 0.1))
GLOBAL, ROLLING = Shutter(0.5e-3), Shutter(60e-6, 9e-6)


def driving(time: float) -> CameraPose:
    return camera_pose(SE2(0.5 + 0.8 * time, 0.9, 0.3 + 1.5 * time), MOUNT)


def seen(lamp: CeilingLamp, camera: PinholeCamera, shutter: Shutter = GLOBAL) -> LampProjection | None:
    motion = CameraMotion(driving, 2.0, shutter.frame_end(2.0, camera.height))
    return project_lamp(3, lamp, camera, shutter, 2.0, motion)


@pytest.mark.parametrize('camera', [PAPER, BENT])
@pytest.mark.parametrize('shutter', [GLOBAL, ROLLING])
def test_the_centre_is_projected_at_the_time_of_its_own_row(camera: PinholeCamera, shutter: Shutter) -> None:
    lamp = CeilingLamp((1.8, 1.8, 2.5))
    projection = seen(lamp, camera, shutter)
    assert projection is not None
    pose = driving(projection.time)
    point = pose.rotation.T @ (np.array(lamp.xyz) - pose.position)
    pixels, _ = cv2.projectPoints(point, np.zeros(3), np.zeros(3), camera.matrix, np.array(camera.distortion))
    np.testing.assert_allclose(projection.centre, pixels.ravel(), atol=2e-3)
    row_start = 2.0 + projection.centre[1] * shutter.row_time
    assert projection.time == pytest.approx(row_start + 0.5 * shutter.exposure, abs=1e-8)
    assert projection.lamp == 3


def test_a_large_disc_at_a_slant_has_the_centroid_and_area_of_its_raster() -> None:
    lamp = CeilingLamp((1.4, 2.4, 1.8), Disc(0.15), rpy=(0.3, 0.0, 0.0))
    projection = seen(lamp, BENT)
    assert projection is not None
    pose = driving(projection.time)
    fine = np.arange(-80.0, 80.0, 0.2)
    u, v = np.array(projection.centre)[:, None] + np.reshape(np.meshgrid(fine, fine), (2, -1))
    rays = BENT.rays_from_pixels(np.column_stack([u, v])) @ pose.rotation.T
    normal = np.array([0.0, -math.sin(0.3), math.cos(0.3)])
    reach = (np.array(lamp.xyz) - pose.position) @ normal / (rays @ normal)
    hits = pose.position + reach[:, None] * rays - lamp.xyz
    inside = (np.linalg.norm(hits, axis=1) < 0.15) & (reach > 0.0)
    assert math.pi * projection.radius**2 == pytest.approx(inside.sum() * 0.2**2, rel=2e-3)
    np.testing.assert_allclose(projection.centroid, [u[inside].mean(), v[inside].mean()], atol=0.02)
    # Perspective parts it from the projected centre.
    assert math.dist(projection.centroid, projection.centre) > 0.5


def test_lamps_behind_or_far_outside_the_view_are_not_projected() -> None:
    for place, camera in (((1.8, 1.8, -1.0), PAPER), ((40.0, 1.8, 2.5), PAPER), ((40.0, 1.8, 2.5), BENT)):
        assert seen(CeilingLamp(place), camera) is None


def test_a_window_next_to_the_camera_may_extend_from_behind_it_into_view() -> None:
    window = CeilingLamp((0.0, 1.0, -0.2), Rectangle(1.0, 6.0), rpy=(np.pi / 2.0, 0.0, 0.0), brightness=500.0)
    camera = PinholeCamera(320, 240, 320.0, 320.0, 159.5, 119.5)
    taken = CeilingCamera(camera, Shutter(2e-3), CeilingLens(0.0, blooming=SHARP))
    turning = lambda time: camera_pose(SE2(0.0, 0.0, 3.0 * time), UPWARD_MOUNT)  # noqa: E731
    light = taken.light(CeilingRoom((window,)), turning, 0.0)
    # The wall at 1 m is seen where it is up to 2.8 m high, half a metre to each side.
    u = 159.5 + 320.0 * 1.0 / np.array([3.4, 2.4, 2.2])
    v = 119.5 + 320.0 * 0.2 / np.array([3.4, 2.4, 2.2])
    np.testing.assert_allclose(light[v.astype(int), u.astype(int)], [0.0, 1.0, 1.0], atol=0.01)
