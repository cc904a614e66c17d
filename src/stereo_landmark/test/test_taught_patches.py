from dataclasses import replace

import cv2
import numpy as np
import pytest
from drawn_wall import Plate, Wall, detect_view, look, teach_view
from place_scenes import RIG, errors_of
from random_places import is_same

from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.core.patches.taught_patches import TaughtPatches
from stereo_landmark.core.place.joint_fit import reproject
from stereo_landmark.core.primitives.primitive import PrimitiveKind, primitive_size
from stereo_landmark.core.settings import LandmarkSettings, PlaceSettings
from stereo_landmark.core.stereo import StereoPoints

PLATES = (Plate(0.45, 0.7, 0.4, 0.3, 60.0), Plate(-0.35, 0.75, 0.36, 0.44, 230.0))
PRINT = tuple(
    Plate(plate.y + dy, plate.z + dz, 0.07, 0.02 + 0.03 * k, 150.0)
    for plate in PLATES
    for k, (dy, dz) in enumerate(((-0.09, 0.06), (0.08, 0.05), (-0.08, -0.06), (0.07, -0.07), (0.0, 0.0)))
)
WALL = Wall((*PLATES, *PRINT))
"""Two plates with print."""
EXACT = LandmarkSettings(place=PlaceSettings(pixel_sigma=0.0, tilt_sigma=0.0))
PLANAR = (0.3, -0.2, 0.08), (-0.4, 0.2, -0.1), (0.1, 0.3, -0.15), (-0.2, -0.3, 0.12)
STATES = np.array([(x, y, 0.0, yaw, 0.0, 0.0) for x, y, yaw in PLANAR])


def seen(wall, state, noise=1.5, seed=1):
    """Return both images with lens blur, so that they are not undersampled."""
    rng = np.random.default_rng(seed)
    clear = [cv2.GaussianBlur(np.float64(each), (0, 0), 0.6) for each in look(wall, state, noise=0.0)]
    return tuple(np.uint8(np.clip(np.rint(i + noise * rng.normal(size=i.shape)), 0, 255)) for i in clear)


def taught(state, seed=1):
    view = detect_view(seen(WALL, state, seed=seed))
    plates = view.left.kinds[PrimitiveKind.QUADRILATERAL].primitives
    one, other, *_ = sorted(plates, key=primitive_size, reverse=True)
    return teach_view(view, {'one': one, 'other': other}, target='plates')


@pytest.fixture(scope='module')
def place():
    return taught(np.zeros(6))


def outlines(place, state, off=0.0):
    """Return the corners as measured by outlines, all with the same error."""
    points = place.coordinates
    pixels = reproject(state, points.positions, RIG).pixels + off
    return StereoPoints(points.names, pixels, np.tile(1e-4 * np.eye(4), (len(points), 1, 1)))


def test_the_points_of_patches_are_where_the_taught_ones_are_seen(place):
    """Present points and their taught 3D points agree with the true displacement within their covariances."""
    squares = []
    for seed, state in enumerate(STATES, 10):
        measured = TaughtPatches(place, 0.0).measure(outlines(place, state), seen(WALL, state, seed=seed))
        found, points = measured.seen, measured.taught
        view = reproject(state, points.positions, RIG)
        error = (found.pixels - view.pixels)[:, :, None]
        J = view.point_jacobian
        spread = found.covariances + J @ points.covariances @ J.transpose(0, 2, 1)
        squares += (error.transpose(0, 2, 1) @ np.linalg.solve(spread, error)).ravel().tolist()
        assert not np.allclose(points.positions, place.coordinates.positions, atol=0.01)
    assert 0.4 < np.mean(squares) / 4.0 < 1.6


def test_the_displacement_follows_from_patches(place):
    errors, squares = [], []
    for seed, state in enumerate(STATES, 20):
        fix = LandmarkLocalizer([place], EXACT).locate(*seen(WALL, state, seed=seed))
        assert isinstance(fix, LandmarkFix)
        assert len(fix.matched_patches) == len(set(fix.matched_patches)) > 0
        error = errors_of(fix.displacement.T_place_base, 0.0, state)[[0, 1, 3]]
        planar = fix.displacement.covariance[np.ix_([0, 1, 3], [0, 1, 3])]
        errors.append(np.hypot(*error[:2]))
        squares.append(error @ np.linalg.solve(planar, error) / 3.0)
    assert max(errors) < 0.004
    assert np.mean(squares) < 3.0


def halved(images):
    """Return replaced image files that do not match the taught corners."""
    left, right = (cv2.resize(each, None, fx=0.5, fy=0.5) for each in (images.left, images.right))
    return replace(images, left=left, right=right)


@pytest.mark.parametrize(('images_of', 'off'), [(lambda _: None, 0.0), (halved, 0.0), (lambda kept: kept, 0.4)])
def test_without_patches_or_beside_them_the_outlines_stay(place, images_of, off):
    """No images, images of another size, or outlines that disagree with the patches."""
    corners, images = outlines(place, STATES[0], off), seen(WALL, STATES[0])
    measured = TaughtPatches(replace(place, images=images_of(place.images)), 0.0).measure(corners, images)
    assert is_same(measured.seen, corners)
    assert is_same(measured.taught, place.coordinates)


def test_a_pair_leaves_no_trace(place):
    """The measurement of a pair does not depend on previous pairs."""
    patches, corners = TaughtPatches(place, 0.0), outlines(place, STATES[0])
    images, others = seen(WALL, STATES[0]), seen(WALL, STATES[1])
    first = patches.measure(corners, images).seen
    patches.measure(outlines(place, STATES[1]), others)
    again = patches.measure(corners, images).seen
    assert is_same(first, again)


def test_a_plate_with_another_print_is_measured_by_its_outline(place):
    """The other plate is still measured by its patch."""
    other = Wall((*PLATES, *PRINT[:5], Plate(-0.35, 0.75, 0.3, 0.36, 120.0)))
    corners = outlines(place, STATES[0])
    measured = TaughtPatches(place, 0.0).measure(corners, seen(other, STATES[0]))
    points, coordinates = measured.seen, measured.taught
    kept = (points.pixels == corners.pixels).all(axis=1)
    same = (coordinates.positions == place.coordinates.positions).all(axis=1)
    assert np.array_equal(kept, same)
    assert kept.sum() == 4
    owners = [name.rsplit('/', 1)[0] for name in corners.names]
    by_outline = {owner for owner, is_kept in zip(owners, kept, strict=True) if is_kept}
    assert len(by_outline) == 1
    assert set(measured.matched_patches) == set(owners) - by_outline


def test_points_that_were_not_seen_are_not_asked_for(place):
    corners, images = outlines(place, STATES[0]), seen(WALL, STATES[0])
    some = corners.subset(np.array(['one' in name for name in corners.names]))
    points = TaughtPatches(place, 0.0).measure(some, images).seen
    assert points.names == some.names
    assert not np.array_equal(points.pixels, some.pixels)


def test_there_and_back_are_inverse(place):
    """Swapping the teach and the repeat pose inverts the displacement."""
    state = STATES[0]
    back = taught(state, seed=3)
    forward, backward = (
        LandmarkLocalizer([lesson]).locate(*seen(WALL, from_where, seed=seed)).displacement.T_place_base
        for lesson, from_where, seed in ((place, state, 3), (back, np.zeros(6), 1))
    )
    whole = forward @ backward
    assert np.hypot(whole.x, whole.y) < 0.003
    assert abs(whole.yaw) < 0.001
