"""Correct poses from simulated views, or a reason for no pose."""

import math
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from floor_views import CAMERA, MOUNT, dots_at, first_dots, is_right, mirrored, pose_over, random_floor, see

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.fix import Fix, NoFix, NoFixReason, PosePrior
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.mount_check import check_mount
from floor_localizer.core.settings import LocalizerSettings
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

TILT = math.radians(2.0)
VIEWS = {
    'clean': {},
    'noisy': {'noise': 0.5},
    'higher': {'scale': 0.05},
    'lower': {'scale': -0.05},
    'tilted': {'tilt': (TILT, -TILT)},
    'higher and tilted': {'scale': 0.03, 'tilt': (-TILT, TILT)},
    'half': {'missing': 0.5},
    'worn and littered': {'missing': 0.25, 'spurious': 21},
}


@pytest.mark.parametrize('disturbance', VIEWS)
def test_a_view_anywhere_gives_the_right_pose(floor, localizer, disturbance):
    rng = np.random.default_rng(1)
    found = 0
    for _ in range(12):
        pose = pose_over(rng)
        result = localizer.locate_dots(see(floor, pose, rng, **VIEWS[disturbance]).dots, CAMERA)
        assert isinstance(result, NoFix) or is_right(result, pose)
        found += isinstance(result, Fix)
    assert found >= 11


@pytest.mark.parametrize('xyz', [(0.0, 0.0, 0.13), (0.3, 0.15, 0.13), (-0.2, 0.0, 0.13)])
@pytest.mark.parametrize('scale', [-0.04, 0.04])
@pytest.mark.parametrize('known', [False, True])
def test_wherever_the_camera_sits_another_height_is_found(floor, indexed_floor, xyz, scale, known):
    rng = np.random.default_rng(2)
    mount = CameraMount(xyz=xyz)
    localizer = FloorLocalizer(indexed_floor, mount)
    for _ in range(3):
        pose = pose_over(rng, mount=mount)
        view = see(floor, pose, rng, mount=mount, scale=scale)
        result = localizer.locate_dots(view.dots, CAMERA, PosePrior(pose, 0.005, 0.03) if known else None)
        assert is_right(result, pose, position=0.0015)
        assert result.used_prior == known
        assert result.scale == pytest.approx(scale, abs=0.005)


def test_tilt_and_height_are_estimated(floor, localizer):
    rng = np.random.default_rng(3)
    for _ in range(5):
        pose, tilt = pose_over(rng), tuple(rng.uniform(-TILT, TILT, 2))
        result = localizer.locate_dots(see(floor, pose, rng, scale=0.02, tilt=tilt, noise=0.02).dots, CAMERA)
        np.testing.assert_allclose(result.tilt, tilt, atol=0.006)
        assert result.scale == pytest.approx(0.02, abs=0.003)


def test_covariance_holds_the_errors(floor, indexed_floor):
    # The map is exact here.
    localizer = FloorLocalizer(indexed_floor, MOUNT, LocalizerSettings(map_sigma=0.0))
    rng = np.random.default_rng(4)
    squares = []
    for _ in range(60):
        pose = pose_over(rng)
        tilt = rng.normal(0.0, 0.01, 2)
        result = localizer.locate_dots(see(floor, pose, rng, tilt=tuple(tilt)).dots, CAMERA)
        found = result.T_map_base
        error = np.array([found.x - pose.x, found.y - pose.y, pose.yaw_to(found)])
        squares.append(error @ np.linalg.solve(result.covariance, error))
    assert 2.0 < np.mean(squares) < 4.0  # of three degrees of freedom


def test_matches_are_the_dots_that_they_are(floor, localizer):
    rng = np.random.default_rng(5)
    view = see(floor, pose_over(rng), rng, spurious=10)
    result = localizer.locate_dots(view.dots, CAMERA)
    real = view.sources >= 0
    assert np.mean(result.matched[real]) > 0.97
    assert np.mean(result.matched[~real]) < 0.3
    both = real & result.matched
    np.testing.assert_allclose(result.map_points[both], floor.points[view.sources[both]], atol=1e-6)
    assert np.all(np.isnan(result.map_points[~result.matched]))
    assert result.match_rate == pytest.approx(np.mean(result.matched))


def test_order_of_the_dots_does_not_matter(floor, localizer):
    rng = np.random.default_rng(6)
    dots = see(floor, pose_over(rng), rng).dots
    order = rng.permutation(len(dots))
    shuffled = replace(dots, pixels=dots.pixels[order])
    first, second = localizer.locate_dots(dots, CAMERA), localizer.locate_dots(shuffled, CAMERA)
    assert is_right(first, second.T_map_base, 1e-6, 1e-6)


def test_another_floor_gives_no_fix(localizer):
    rng = np.random.default_rng(7)
    other_floor = random_floor(99)
    for effort in (1.0, 0.04):
        result = localizer.locate_dots(see(other_floor, pose_over(rng), rng).dots, CAMERA, effort=effort)
        assert isinstance(result, NoFix)
        assert result.reason in {NoFixReason.NO_MATCH, NoFixReason.UNCERTAIN}


def test_a_mirrored_image_is_reported(floor, localizer):
    rng = np.random.default_rng(8)
    for _ in range(3):
        result = localizer.locate_dots(mirrored(see(floor, pose_over(rng), rng).dots), CAMERA)
        assert result.reason is NoFixReason.MIRRORED


@pytest.mark.parametrize('number', [0, 1, 4])
def test_few_dots_have_their_reasons(floor, localizer, number):
    rng = np.random.default_rng(9)
    result = localizer.locate_dots(first_dots(see(floor, pose_over(rng), rng).dots, number), CAMERA)
    assert result.reason is (NoFixReason.TOO_FEW_DOTS if number else NoFixReason.NO_DOTS)
    assert len(result.dots) == number


def test_another_height_than_allowed_gives_the_right_pose_or_none(floor, localizer):
    rng = np.random.default_rng(10)
    for scale in 3 * (-0.1, 0.1):
        pose = pose_over(rng)
        result = localizer.locate_dots(see(floor, pose, rng, scale=scale).dots, CAMERA)
        assert isinstance(result, NoFix) or is_right(result, pose)


@pytest.mark.parametrize('missing', [0.0, 1.0])
def test_a_view_full_of_litter_comes_to_an_end_and_gives_no_wrong_pose(floor, localizer, missing):
    rng = np.random.default_rng(11)
    pose = pose_over(rng)
    view = see(floor, pose, rng, missing=missing, spurious=600)
    result = localizer.locate_dots(view.dots, CAMERA)
    assert isinstance(result, NoFix) or is_right(result, pose)


@pytest.fixture(scope='module')
def twice():
    """A floor that repeats itself."""
    once = random_floor(20, (0.4, 0.3)).points
    points = np.vstack([once, np.add(once, (0.4, 0.0))])
    return DotMap(points, np.full(len(points), math.nan))


def test_a_floor_that_repeats_itself_is_ambiguous_without_a_prior(twice):
    rng = np.random.default_rng(12)
    localizer = FloorLocalizer(index_map(twice), MOUNT)
    for _ in range(3):
        pose = pose_over(rng, (0.4, 0.3))
        dots = see(twice, pose, rng).dots
        assert localizer.locate_dots(dots, CAMERA).reason is NoFixReason.AMBIGUOUS
        for place in (pose, SE2(0.4, 0.0, 0.0) @ pose):
            assert is_right(localizer.locate_dots(dots, CAMERA, PosePrior(place, 0.02, 0.1)), place)


@pytest.mark.parametrize('turn', [0.05, 1.0, math.pi])
def test_near_a_prior_the_pose_is_found_with_it(floor, localizer, turn):
    rng = np.random.default_rng(13)
    for _ in range(4):
        pose = pose_over(rng)
        off = SE2(*rng.uniform(-0.01, 0.01, 2), rng.uniform(-0.9, 0.9) * turn)
        view = see(floor, pose, rng, missing=0.3, spurious=10)
        result = localizer.locate_dots(view.dots, CAMERA, PosePrior(pose @ off, 0.015, turn))
        assert is_right(result, pose)
        assert result.used_prior


def test_a_wrong_prior_is_overcome_unless_it_is_strict(floor, localizer):
    pose = SE2(0.2, 0.2, 0.0)
    dots = see(floor, pose, np.random.default_rng(14)).dots
    wrong = PosePrior(SE2(0.7, 0.4, 0.0), 0.02, 0.1)
    result = localizer.locate_dots(dots, CAMERA, wrong)
    assert is_right(result, pose)
    assert not result.used_prior
    wide = PosePrior(SE2(5.0, 5.0, 0.0), 1.0, math.pi)
    for held in (wrong, wide):
        result = localizer.locate_dots(dots, CAMERA, replace(held, is_strict=True))
        assert result.reason is NoFixReason.OUTSIDE_AREA
    near = replace(wide, T_map_base=SE2(0.5, 0.5, 2.0), is_strict=True)
    assert is_right(localizer.locate_dots(dots, CAMERA, near), pose)


def test_pairs_find_what_constellations_cannot(floor, localizer):
    rng = np.random.default_rng(16)
    found = {0.04: 0, 1.0: 0}
    for _ in range(10):
        pose = pose_over(rng)
        dots = see(floor, pose, rng, missing=0.65).dots
        for effort in found:
            result = localizer.locate_dots(dots, CAMERA, effort=effort)
            assert isinstance(result, NoFix) or is_right(result, pose)
            found[effort] += isinstance(result, Fix)
    assert found[1.0] > found[0.04]
    assert found[1.0] >= 8


def test_a_slanting_camera_with_dots_beyond_the_horizon_keeps_dots_and_matches_together(floor, indexed_floor):
    rng = np.random.default_rng(17)
    # It looks ahead, 35 degrees down: the upper part of its wide image is above the horizon.
    mount = CameraMount(xyz=(0.0, 0.0, 0.05), rpy=(-math.pi / 2.0 - math.radians(35.0), 0.0, -math.pi / 2.0))
    camera = PinholeCamera(640, 480, 260.0, 260.0, 319.5, 239.5)
    pose = SE2(0.3, 0.3, 0.1)
    view = see(floor, pose, rng, mount=mount, camera=camera)
    near = np.linalg.norm(floor.points[view.sources] - (0.37, 0.3), axis=1) < 0.05
    sky = np.column_stack([rng.uniform(0.0, 639.0, 30), rng.uniform(0.0, 40.0, 30)])
    dots = dots_at(np.vstack([sky, view.dots.pixels[near]]))
    result = FloorLocalizer(indexed_floor, mount).locate_dots(dots, camera)
    assert is_right(result, pose)
    assert len(result.dots) == len(result.matched) == len(result.map_points) == near.sum()
    np.testing.assert_array_equal(result.dots.pixels, view.dots.pixels[near])
    expected = np.where(result.matched[:, None], floor.points[view.sources[near]], np.nan)
    np.testing.assert_allclose(result.map_points, expected, atol=1e-6)


def test_only_dots_beyond_the_horizon_are_no_dots(indexed_floor):
    # Ten degrees down, seen through a lens of 38 degrees: the horizon is at row 57.
    mount = CameraMount(rpy=(-math.pi / 2.0 - math.radians(10.0), 0.0, -math.pi / 2.0))
    sky = dots_at(np.random.default_rng(0).uniform((0.0, 0.0), (234.0, 50.0), (20, 2)))
    assert FloorLocalizer(indexed_floor, mount).locate_dots(sky, CAMERA).reason is NoFixReason.NO_DOTS


def test_floor_points_are_where_the_camera_sees_them(floor, localizer):
    rng = np.random.default_rng(18)
    pose = pose_over(rng)
    view = see(floor, pose, rng, noise=0.0)
    points = localizer.floor_points(view.dots, CAMERA)
    np.testing.assert_allclose(pose.transform(points.points), floor.points[view.sources], atol=1e-6)
    assert np.all(points.sigmas > 0.0)


def test_image_in_pose_out(floor, localizer):
    """Extraction and matching of the map's discs, rendered by supersampling."""
    rng = np.random.default_rng(19)
    pose = SE2(0.4, 0.3, 1.0)
    pixels = see(floor, pose, rng, noise=0.0).dots.pixels
    fine = (np.arange(235 * 4) + 0.5) / 4.0 - 0.5
    dark = np.zeros((940, 940))
    for u, v in pixels:
        columns, rows = np.flatnonzero(np.abs(fine - u) < 4.0), np.flatnonzero(np.abs(fine - v) < 4.0)
        inside = (fine[rows, None] - v) ** 2 + (fine[columns] - u) ** 2 < 3.2**2
        dark[np.ix_(rows, columns)] = np.maximum(dark[np.ix_(rows, columns)], inside)
    coverage = dark.reshape(235, 4, 235, 4).mean(axis=(1, 3))
    image = np.clip(200.0 - 150.0 * coverage + rng.normal(0.0, 2.0, coverage.shape), 0, 255).astype(np.uint8)
    assert is_right(localizer.locate(image, CAMERA), pose)


@pytest.mark.parametrize(('height', 'rpy', 'fault'), [
    (0.0, CameraMount().rpy, 'camera_xyz: z is'), (-0.13, CameraMount().rpy, 'camera_xyz: z is'),
    (0.13, (0.0, 0.0, 0.0), r'camera_rpy: .* does not look at the floor'),
    (0.13, (-math.pi / 2.0, 0.0, -math.pi / 2.0), r'camera_rpy: .* does not look at the floor'),
    *((0.13, (math.pi + lean, 0.0, -math.pi / 2.0), None) for lean in (0.0, 0.5, -1.0)),
])  # fmt: skip
def test_a_camera_must_be_above_the_floor_and_look_at_it(height, rpy, fault):
    with pytest.raises(FloorLocalizerError, match=fault) if fault else nullcontext():
        check_mount(CameraMount((0.1, 0.0, height), rpy))
