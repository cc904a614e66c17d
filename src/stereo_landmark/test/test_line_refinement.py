"""Straight edges alone, and four sides that are refined jointly up to the corners."""

import math

import numpy as np
import pytest
from antialiased_shapes import photograph
from consistency import mahalanobis
from seen_shapes import SIZE, box, hide, polygon_light, polygon_photo, turned_rectangle

from stereo_landmark.core.primitives.corner import intersect_lines, joint_corner_covariance
from stereo_landmark.core.primitives.line_refinement import refine_lines

BAR = turned_rectangle((50, 45), 70.0, 40.0, 0.3)
NORMAL = np.array([-math.sin(0.3), math.cos(0.3)])


def refine_line(image, begin, end):
    """Return one straight edge alone."""
    (line,) = refine_lines(image, np.array([[begin, end]]))
    return line


@pytest.mark.parametrize('blur', [0.3, 0.7, 1.5, 2.5])
def test_measures_the_blur_of_the_edge(blur):
    line = refine_line(polygon_photo(BAR, blur=blur), BAR[0] + 0.4, BAR[1] + 0.4)
    assert line.blur == pytest.approx(blur, rel=0.25)


def test_starts_a_pixel_off_and_arrives():
    line = refine_line(polygon_photo(BAR), BAR[0] + NORMAL, BAR[1] - 0.8 * NORMAL)
    assert abs((line.middle - BAR[0]) @ NORMAL) < 4.0 * math.sqrt(line.variances[0])
    assert abs(line.direction @ NORMAL) < 4.0 * math.sqrt(line.variances[1])


def test_a_nearby_line_does_not_bias_it():
    nearby = turned_rectangle([50, 45] - 15.0 * NORMAL, 70.0, 3.0, 0.3)
    light = polygon_light(BAR) + polygon_light(nearby, ground=0.0, contrast=70.0)
    line = refine_line(photograph(light, 1.0), BAR[0], BAR[1])
    assert abs((line.middle - BAR[0]) @ NORMAL) < 0.04


def test_leaves_out_what_hides_a_part():
    corners = turned_rectangle((50, 45), 70.0, 40.0, 0.0)
    light = hide(polygon_light(corners), 30.0, box(30, 20.0, 48, 27.5))
    line = refine_line(photograph(light, 1.0), corners[0], corners[1])
    assert abs(line.middle[1] - 25.0) < 0.04
    assert line.inlier_fraction < 0.9


@pytest.mark.parametrize('end', [(60.0, 30.0), (24.0, 20.0)])
def test_a_short_or_empty_place_has_no_line(end):
    assert refine_lines(np.full((90, 100), 120, np.uint8), np.array([[(20.0, 20.0), end]])) is None


PICTURES = 40
ROWS, COLUMNS = np.mgrid[: SIZE[1], : SIZE[0]]


def square(number):
    rng = np.random.default_rng(number)
    return turned_rectangle(rng.uniform(44.0, 48.0, 2), 32.0, 28.0, rng.uniform(-0.3, 0.3))


def measured(corners, light, number, is_closed):
    """Return the errors of the corners, shape (8,) [px], and their covariance."""
    image = photograph(light, 2.0, number)
    lines = refine_lines(image, np.stack([corners, np.roll(corners, -1, axis=0)], axis=1), is_closed)
    found = np.array([intersect_lines(lines[k - 1], lines[k]) for k in range(4)])
    return (found - corners).ravel(), joint_corner_covariance(lines, found)


def test_joint_refinement_is_more_accurate_and_consistent():
    squares, stated, alone = [], [], []
    for number in range(PICTURES):
        corners = square(number)
        light = polygon_light(corners)
        errors, covariance = measured(corners, light, number, True)
        squares.append(np.mean(errors**2))
        stated.append(mahalanobis(errors, covariance))
        alone.append(np.mean(measured(corners, light, number, False)[0] ** 2))
    assert np.mean(squares) < 0.8 * np.mean(alone)
    assert 0.5 < np.mean(stated) < 1.5


@pytest.mark.parametrize(
    'shade',
    [1.0 + 0.002 * (COLUMNS - 46.0), 1.0 + 0.002 * (ROWS - 46.0), np.where(COLUMNS < 46.0, 1.0, 0.85)],
    ids=['across', 'down', 'shadow'],
)
@pytest.mark.newest_set_only
def test_uneven_light_moves_corners_by_hardly_anything(shade):
    corners = turned_rectangle((46.3, 45.6), 32.0, 28.0, 0.1)
    light = polygon_light(corners) * shade
    errors = [measured(corners, light, number, True)[0] for number in range(PICTURES)]
    assert np.abs(np.mean(errors, axis=0)).max() < 0.025


def test_a_skewed_corner_is_where_its_sides_meet():
    corners = np.array([[30.0, 30.0], [66.0, 26.0], [72.0, 58.0], [28.0, 52.0]])
    light = polygon_light(corners)
    errors = [measured(corners, light, number, True)[0] for number in range(PICTURES)]
    assert np.abs(np.mean(errors, axis=0)).max() < 0.012
