"""Stereo images match the stereo geometry, also after rectification with the calibration."""

import math

import numpy as np
import pytest
import yaml
from flat_patches import patches

from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.stereo_rig import StereoRig, calibration_yaml, raw_rig, render_pair
from shirube_core.geometry import SE2


def test_the_file_holds_the_calibration() -> None:
    for found, name in zip(raw_rig().calibrations(), ('left', 'right'), strict=True):
        read = yaml.safe_load(calibration_yaml(found, name))
        assert (read['image_width'], read['image_height'], read['camera_name']) == (752, 480, name)
        assert read['distortion_model'] == 'plumb_bob'
        for field, shape, values in (
            ('camera_matrix', (3, 3), found.camera.matrix),
            ('distortion_coefficients', (1, 5), found.camera.distortion),
            ('rectification_matrix', (3, 3), found.rotation),
            ('projection_matrix', (3, 4), found.projection),
        ):
            assert (read[field]['rows'], read[field]['cols']) == shape
            np.testing.assert_array_equal(
                np.array(read[field]['data']).reshape(shape), np.reshape(values, shape)
            )


POSE = SE2(-3.0, 0.3, -0.2)


def test_the_rig_has_the_goals_of_the_accuracy_runs() -> None:
    rig = StereoRig()
    assert rig.left.intrinsics.fx >= 700.0
    assert rig.baseline >= 0.2
    assert rig.is_rectified
    assert not raw_rig().is_rectified


def test_a_level_rig_looks_along_the_robot() -> None:
    left, right = StereoRig().camera_poses(SE2(1.0, 2.0, 0.5 * math.pi))
    np.testing.assert_allclose(left.rotation[:, 2], (0.0, 1.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(left.rotation[:, 1], (0.0, 0.0, -1.0), atol=1e-12)
    np.testing.assert_allclose(right.position - left.position, (0.24, 0.0, 0.0), atol=1e-12)


def test_points_have_the_disparity_of_their_depth() -> None:
    rig, points = StereoRig(), np.array(list(corridor().points_map().values()))
    left, right = rig.camera_poses(POSE)
    here, there = left.camera_points(points), right.camera_points(points)
    seen = here[:, 2] > 0.5
    depth = here[seen, 2]
    pixels = [c.intrinsics.pixels_from_points(x[seen]) for c, x in ((rig.left, here), (rig.right, there))]
    np.testing.assert_allclose(pixels[0][:, 1], pixels[1][:, 1], atol=1e-9)
    np.testing.assert_allclose(pixels[0][:, 0] - pixels[1][:, 0], 720.0 * 0.24 / depth, rtol=1e-9)


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
    depth = -rig.calibrations()[1].projection[0, 3] / (left[:, 0] - right[:, 0])
    np.testing.assert_allclose(depth, here[:, 2], rtol=1e-6)
    assert -rig.calibrations()[1].projection[0, 3] / rig.calibrations()[1].projection[0, 0] == pytest.approx(
        rig.baseline
    )


def test_a_pair_is_two_pictures_with_noise_of_their_own() -> None:
    scene, rig = patches(), StereoRig()
    left, right = render_pair(scene, rig, POSE, np.random.default_rng(0))
    assert left.shape == right.shape == (480, 752)
    again = render_pair(scene, rig, POSE, np.random.default_rng(0))
    np.testing.assert_array_equal(left, again[0])
    clean = render_pair(scene, rig, POSE)
    noise = [
        seen[:60].astype(float) - without[:60] for seen, without in zip((left, right), clean, strict=True)
    ]
    assert abs(np.corrcoef(noise[0].ravel(), noise[1].ravel())[0, 1]) < 0.05


def test_no_seam_shows_where_surfaces_meet() -> None:
    scene = corridor(CorridorDesign(1))
    for camera, pose in zip((StereoRig().left, raw_rig().left), (SE2(-5.0, 0.3, 0.1), POSE), strict=True):
        light = camera.light(scene, StereoRig().camera_poses(pose)[0])
        assert light.min() > 0.005
