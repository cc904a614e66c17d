"""Stereo images match the stereo geometry, also after rectification with the calibration."""

import math

import numpy as np
import pytest
import yaml
from flat_patches import patches

from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.stereo_rig import StereoRig, raw_rig, render_pair
from shirube_core.geometry import SE2
from shirube_ros.camera.files import calibration_text


def test_the_file_holds_the_calibration() -> None:
    for found, name in zip(raw_rig().calibrations(), ('left', 'right'), strict=True):
        read = yaml.safe_load(calibration_text(name, found.camera, found.rotation, found.projection))
        assert (read['image_width'], read['image_height'], read['camera_name']) == (752, 480, name)
        assert read['distortion_model'] == 'plumb_bob'
        for field, shape, values in (
            ('camera_matrix', (3, 3), found.camera.matrix),
            ('distortion_coefficients', (1, 5), found.camera.distortion),
            ('rectification_matrix', (3, 3), found.rotation),
            ('projection_matrix', (3, 4), found.projection),
        ):
            assert (read[field]['rows'], read[field]['cols']) == shape
            np.testing.assert_allclose(read[field]['data'], np.ravel(values), atol=1e-11)


POSE = SE2(-3.0, 0.3, -0.2)


def test_a_level_rig_looks_along_the_robot() -> None:
    left, right = StereoRig().camera_poses(SE2(1.0, 2.0, 0.5 * math.pi))
    np.testing.assert_allclose(left.rotation[:, 2], (0.0, 1.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(left.rotation[:, 1], (0.0, 0.0, -1.0), atol=1e-12)
    np.testing.assert_allclose(right.position - left.position, (0.24, 0.0, 0.0), atol=1e-12)


@pytest.mark.parametrize('rig', [StereoRig(), raw_rig()])
def test_the_calibration_takes_both_cameras_to_common_rows_and_to_depth(rig: StereoRig) -> None:
    points = np.array([(0.0, y, z) for y in (-0.8, 0.0, 0.8) for z in (0.8, 1.3, 1.8)])
    rectified = []
    for found, pose in zip(rig.calibrations(), rig.camera_poses(POSE), strict=True):
        pixels = found.camera.pixels_from_points(pose.camera_points(points))
        turned = found.camera.rays_from_pixels(pixels) @ found.rotation.T @ found.projection[:, :3].T
        rectified.append(turned[:, :2] / turned[:, 2:])
    left, right = rectified
    np.testing.assert_allclose(left[:, 1], right[:, 1], atol=1e-5)
    here = rig.camera_poses(POSE)[0].camera_points(points) @ rig.calibrations()[0].rotation.T
    depth = -found.projection[0, 3] / (left[:, 0] - right[:, 0])
    np.testing.assert_allclose(depth, here[:, 2], rtol=1e-6)
    assert -found.projection[0, 3] / found.projection[0, 0] == pytest.approx(rig.baseline)


def test_a_pair_is_two_pictures_with_noise_of_their_own() -> None:
    scene, rig = patches(), StereoRig()
    noisy, again = (np.array(render_pair(scene, rig, POSE, np.random.default_rng(0))) for _ in range(2))
    np.testing.assert_array_equal(noisy, again)
    noise = noisy[:, :60].astype(float) - np.array(render_pair(scene, rig, POSE))[:, :60]
    assert abs(np.corrcoef(noise.reshape(2, -1))[0, 1]) < 0.05


def test_no_seam_shows_where_surfaces_meet() -> None:
    scene = corridor(CorridorDesign(1))
    for camera, pose in zip((StereoRig().left, raw_rig().left), (SE2(-5.0, 0.3, 0.1), POSE), strict=True):
        light = camera.light(scene, StereoRig().camera_poses(pose)[0])
        assert light.min() > 0.005
