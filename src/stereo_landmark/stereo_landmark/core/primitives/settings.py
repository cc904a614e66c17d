"""Detection settings of the primitives."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class PrimitiveSettings:
    """Settings of the four detectors; lengths are in image pixels."""

    side_length_min: float = setting(
        8.0, 'minimum length of a line segment', unit='px', minimum=3.0, maximum=1000.0
    )
    side_gap_max: float = setting(
        0.5, 'longest gap to join, as a fraction of both line segments together', minimum=0.0, maximum=2.0
    )
    side_offset_max: float = setting(
        1.5, 'largest offset of joined line segments across the line', unit='px', minimum=0.2, maximum=10.0
    )
    corner_gap_max: float = setting(
        4.0, 'largest gap between an arm of a corner and the vertex', unit='px', minimum=1.0, maximum=50.0
    )
    corner_angle_min: float = setting(
        0.35, 'smallest angle between the arms of a corner', unit='rad', minimum=0.05, maximum=1.5
    )
    hidden_corner_max: float = setting(
        30.0,
        'largest gap between a side of a quadrilateral and an occluded corner',
        unit='px',
        minimum=1.0,
        maximum=300.0,
    )
    side_seen_min: float = setting(
        0.3, 'smallest visible fraction of each side of a quadrilateral', minimum=0.05, maximum=1.0
    )
    outline_seen_min: float = setting(
        0.6, 'smallest visible fraction of the outline of a quadrilateral', minimum=0.1, maximum=1.0
    )
    parallel_angle_max: float = setting(
        0.09, 'largest angle between parallel lines', unit='rad', minimum=0.01, maximum=0.5
    )
    parallel_length_min: float = setting(
        16.0, 'minimum length of parallel lines', unit='px', minimum=4.0, maximum=1000.0
    )
    parallel_width_max: float = setting(
        120.0, 'largest distance between parallel lines', unit='px', minimum=2.0, maximum=2000.0
    )
    parallel_overlap_min: float = setting(
        0.6, 'smallest overlap of parallel lines, as a fraction of the longer', minimum=0.1, maximum=1.0
    )
    ellipse_axis_min: float = setting(
        5.0, 'smallest semi-axis of an ellipse', unit='px', minimum=2.0, maximum=1000.0
    )
    ellipse_axis_max: float = setting(
        300.0, 'largest semi-axis of an ellipse', unit='px', minimum=5.0, maximum=5000.0
    )
    ellipse_flatness_min: float = setting(
        0.2, 'smallest ratio of the axes of an ellipse', minimum=0.05, maximum=1.0
    )
    ellipse_seen_min: float = setting(
        0.45, 'smallest visible fraction of the outline of an ellipse', minimum=0.1, maximum=1.0
    )
