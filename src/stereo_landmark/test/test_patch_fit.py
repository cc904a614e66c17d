import math

import cv2
import numpy as np
import pytest
from consistency import mahalanobis
from painted_patches import CORNERS, homography, light, moved, photograph

from stereo_landmark.core.patches.patch_template import patch_template
from stereo_landmark.core.patches.taught_patches import align_patch

VIEWS = {
    'as taught': homography(shift=(0.3, -0.6)),
    'larger': homography(scale=1.25, shift=(0.4, 0.2)),
    'smaller': homography(scale=0.8, shift=(-0.4, 0.1)),
    'turned': homography(turn=math.radians(15.0), shift=(-0.2, 0.7)),
    'leaning': homography(scale=1.05, lean=0.12, shift=(0.1, 0.4)),
}


def template_of(image):
    template = patch_template(image, CORNERS)
    assert template is not None
    return template


def aligned(template, image, start):
    found = align_patch(template, image, start)
    assert found is not None
    return found


def derivatives(H, points):
    """Return the Jacobian of points in another picture by those in the first one, shape (8, 8)."""
    steps = 1e-4 * np.eye(8).reshape(8, 4, 2)
    return np.column_stack([(moved(points + s, H) - moved(points - s, H)).ravel() / 2e-4 for s in steps])


@pytest.mark.parametrize('name', VIEWS)
def test_errors_are_as_large_as_stated(name):
    H, squares = VIEWS[name], []
    there, here = light(), light(H)
    for seed in range(40):
        rng = np.random.default_rng(seed)
        template = template_of(photograph(there, rng=rng))
        start = moved(CORNERS, H) + rng.normal(scale=0.2, size=(4, 2))
        found = aligned(template, photograph(here, rng=rng), start)
        error = (found.points - moved(template.pixels, H)).ravel()
        by_taught = derivatives(H, template.pixels)
        spread = found.covariance + by_taught @ found.taught_covariance @ by_taught.T
        squares.append(mahalanobis(error, spread))
    # 8 x 40 squares: mean 1 within 0.08; the model error, absent here, makes it smaller.
    assert 0.5 < np.mean(squares) < 1.25


def test_the_error_does_not_depend_on_the_part_of_a_pixel():
    """No subpixel bias: the mean error is small compared with its standard deviation."""
    there = light()
    for shift in (0.0, 0.25, 0.5, 0.75):
        H, errors = homography(shift=(shift, 0.0)), []
        here = light(H)
        for seed in range(30):
            rng = np.random.default_rng(seed)
            template = template_of(photograph(there, 4.0, rng))
            found = aligned(template, photograph(here, 4.0, rng), moved(CORNERS, H))
            errors.append((found.points - moved(template.pixels, H)).mean(axis=0))
        spread = np.std(errors, axis=0) / math.sqrt(len(errors))
        assert (np.abs(np.mean(errors, axis=0)) < 4.0 * spread).all()


@pytest.mark.parametrize(('scale', 'blur'), [(1.0, 1.0), (1.0, 1.5), (0.75, 0.7), (0.6, 0.7)])
def test_fine_print_that_blurs_away_makes_nothing_smaller(scale, blur):
    """Fine print loses contrast before the outline does, which a single gain cannot model."""
    H, growths = homography(scale=scale, shift=(0.3, -0.2)), []
    there, here = (
        cv2.GaussianBlur(light(view, blobs=90, fineness=(0.7, 1.2)), (0, 0), sigma)
        for view, sigma in ((None, 0.7), (H, blur))
    )
    for seed in range(6):
        rng = np.random.default_rng(seed)
        template = template_of(photograph(there, 1.0, rng))
        found = align_patch(template, photograph(here, 1.0, rng), moved(CORNERS, H))
        if found is not None:
            outward = np.sign(found.points - found.points.mean(axis=0))
            growths.append(np.mean(outward * (found.points - moved(template.pixels, H))))
    assert len(growths) > 3
    assert abs(np.mean(growths)) < 0.006


@pytest.mark.parametrize(('gain', 'offset'), [(0.6, 10.0), (1.3, -20.0)])
def test_gain_offset_and_shading_change_nothing(gain, offset):
    H = homography(shift=(0.3, -0.2))
    picture = light(H)
    shade = 1.0 + 0.05 * np.linspace(-1.0, 1.0, picture.shape[1])
    template = template_of(photograph(light(), 0.0))
    plain, other = (
        aligned(template, photograph(each, 0.0), moved(CORNERS, H))
        for each in (picture, gain * shade * picture + offset)
    )
    assert other.points == pytest.approx(plain.points, abs=0.02)
    assert other.points == pytest.approx(moved(template.pixels, H), abs=0.02)


def test_a_moved_needle_is_left_out():
    H = homography(shift=(0.4, 0.3))
    there, here = light(), light(H)
    there[50:70, 66:70] -= 80.0
    here[56:60, 60:80] -= 80.0
    template = template_of(photograph(np.maximum(there, 0.0)))
    found = aligned(template, photograph(np.maximum(here, 0.0)), moved(CORNERS, H))
    error = (found.points - moved(template.pixels, H)).ravel()
    spread = found.covariance + found.taught_covariance
    assert mahalanobis(error, spread) < 30.0 / 8.0


def test_a_print_behind_its_frame_is_not_taken_for_the_plane_of_both():
    """In an oblique view print behind its frame is shifted, by less than the gate of outlines."""
    H, behind = homography(), homography(shift=(0.17, 0.0))
    frame = np.zeros_like(light())
    frame[35:86, 40:101] = 1.0
    inner = cv2.GaussianBlur(cv2.erode(frame, np.ones((9, 9))), (0, 0), 0.8)
    here = (1.0 - inner) * light(H) + inner * light(behind)
    for seed in range(5):
        rng = np.random.default_rng(seed)
        template = template_of(photograph(light(), 1.0, rng))
        assert align_patch(template, photograph(light(), 1.0, rng), CORNERS) is not None
        assert align_patch(template, photograph(here, 1.0, rng), CORNERS) is None


HALF = light()
HALF[:, :70] = 200.0
BLANK = np.full((120, 140), 90.0)


@pytest.mark.parametrize(
    ('picture', 'shift'),
    [(HALF, 0.0), (light(seed=2), 0.0), (BLANK, 0.0), (light(), 38.0), (light(), 90.0)],
    ids=['half of it', 'other paint', 'nothing there', 'at the border', 'outside'],
)
def test_what_is_not_as_it_was_taught_is_not_found(picture, shift):
    start = CORNERS + np.array([shift, 0.0])
    assert align_patch(template_of(photograph(light())), photograph(picture), start) is None


def test_a_patch_that_is_blank_or_at_the_border_of_the_image_is_none():
    assert patch_template(photograph(BLANK, 1.5), CORNERS) is None
    assert patch_template(photograph(light()), CORNERS - [38.0, 0.0]) is None
