"""Rendered images of shapes, and their segments and line segments for the detectors."""

import math

import numpy as np
from antialiased_shapes import coverage, ellipse_intervals, photograph, polygon_intervals

from stereo_landmark.core.edges.edges import extract_edges, trace_segments
from stereo_landmark.core.primitives.line_segments import fit_line_segments
from stereo_landmark.core.settings import EdgeSettings, PrimitiveSettings

PRIMITIVES = PrimitiveSettings()
SIZE = (100, 90)


def segments_of(image, **settings):
    edges = EdgeSettings(**settings)
    return trace_segments(extract_edges(image, edges), edges)


def sides_of(image, **settings):
    return fit_line_segments(segments_of(image), PrimitiveSettings(**settings))


def ellipse_light(centre, axes, tilt, *, ground=180.0, contrast=-80.0, blur=0.7):
    return ground + contrast * coverage(ellipse_intervals(centre, axes, tilt), SIZE, blur)


def polygon_light(corners, *, ground=180.0, contrast=-80.0, blur=0.7):
    return ground + contrast * coverage(polygon_intervals(corners), SIZE, blur)


def ellipse_photo(centre, axes, tilt, *, noise=2.0, seed=0, **light):
    return photograph(ellipse_light(centre, axes, tilt, **light), noise, seed)


def polygon_photo(corners, *, noise=2.0, seed=0, **light):
    return photograph(polygon_light(corners, **light), noise, seed)


def hide(light, level, corners):
    """Return the light with a polygon of one level in front."""
    return light + polygon_light(corners, ground=0.0, contrast=1.0) * (level - light)


def box(left, top, right, bottom):
    """Return the corners of an upright rectangle."""
    return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])


def turned_rectangle(centre, length, height, angle):
    c, s = math.cos(angle), math.sin(angle)
    half = 0.5 * np.array([[-length, -height], [length, -height], [length, height], [-length, height]])
    return half @ np.array([[c, s], [-s, c]]) + np.asarray(centre)
