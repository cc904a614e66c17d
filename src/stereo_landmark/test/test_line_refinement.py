import math

import numpy as np
import pytest
from seen_shapes import SIZE, polygon_photo, turned_rectangle

from scene_simulator.antialiased_shapes import coverage, photograph, polygon_intervals
from stereo_landmark.core.primitives.line_refinement import refine_lines


def refine_line(image, begin, end):
    lines = refine_lines(image, np.array([[begin, end]]))
    return None if lines is None else lines[0]


@pytest.mark.parametrize('blur', [0.3, 0.7, 1.5, 2.5])
def test_measures_the_blur_of_the_edge(blur):
    corners = turned_rectangle((50, 45), 70.0, 40.0, 0.3)
    line = refine_line(polygon_photo(corners, blur=blur), corners[0] + 0.4, corners[1] + 0.4)
    assert line is not None
    assert line.blur == pytest.approx(blur, rel=0.25)


def test_starts_a_pixel_off_and_arrives():
    corners = turned_rectangle((50, 45), 70.0, 40.0, 0.3)
    normal = np.array([-math.sin(0.3), math.cos(0.3)])
    line = refine_line(polygon_photo(corners), corners[0] + normal, corners[1] - 0.8 * normal)
    assert line is not None
    assert abs((line.middle - corners[0]) @ normal) < 4.0 * math.sqrt(line.variances[0])
    assert abs(line.direction @ normal) < 4.0 * math.sqrt(line.variances[1])


def test_a_nearby_line_does_not_bias_it():
    corners = turned_rectangle((50, 45), 70.0, 40.0, 0.3)
    light = 180.0 - 80.0 * coverage(polygon_intervals(corners), SIZE, 0.7)
    nearby = turned_rectangle(
        np.array([50, 45]) + 15.0 * np.array([math.sin(0.3), -math.cos(0.3)]), 70.0, 3.0, 0.3
    )
    image = photograph(light + 70.0 * coverage(polygon_intervals(nearby), SIZE, 0.7), 1.0)
    line = refine_line(image, corners[0], corners[1])
    assert line is not None
    assert abs((line.middle - corners[0]) @ [-math.sin(0.3), math.cos(0.3)]) < 0.04


def test_leaves_out_what_hides_a_part():
    corners = turned_rectangle((50, 45), 70.0, 40.0, 0.0)
    light = 180.0 - 80.0 * coverage(polygon_intervals(corners), SIZE, 0.7)
    hider = coverage(polygon_intervals([[30, 20.0], [48, 20.0], [48, 27.5], [30, 27.5]]), SIZE, 0.7)
    line = refine_line(photograph(light * (1 - hider) + 30.0 * hider, 1.0), corners[0], corners[1])
    assert line is not None
    assert abs(line.middle[1] - 25.0) < 0.04
    assert line.inlier_fraction < 0.9


def test_a_short_or_empty_place_has_no_line():
    image = np.full((90, 100), 120, np.uint8)
    assert refine_line(image, np.array([20.0, 20.0]), np.array([60.0, 30.0])) is None
    assert refine_line(image, np.array([20.0, 20.0]), np.array([24.0, 20.0])) is None
