"""What is taken for a primitive."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class PrimitiveSettings:
    """How the four detectors choose; lengths are pixels of the image."""

    side_length_min: float = setting(
        8.0, 'shorter straight parts are no sides', unit='px', minimum=3.0, maximum=1000.0
    )
    side_gap_max: float = setting(
        0.5, 'longest gap in a side, as a part of what is seen beside it', minimum=0.0, maximum=2.0
    )
    side_offset_max: float = setting(
        1.5, 'how far the parts of a side may lie off its line', unit='px', minimum=0.2, maximum=10.0
    )
    corner_gap_max: float = setting(
        4.0, 'how far a side of a corner may end from the vertex', unit='px', minimum=1.0, maximum=50.0
    )
    corner_angle_min: float = setting(
        0.35, 'sides that differ less in direction make no corner', unit='rad', minimum=0.05, maximum=1.5
    )
    hidden_corner_max: float = setting(
        30.0,
        'how far a side of a quadrilateral may end from a hidden corner',
        unit='px',
        minimum=1.0,
        maximum=300.0,
    )
    side_seen_min: float = setting(
        0.3, 'part of each side of a quadrilateral that must be seen', minimum=0.05, maximum=1.0
    )
    outline_seen_min: float = setting(
        0.6, 'part of the outline of a quadrilateral that must be seen', minimum=0.1, maximum=1.0
    )
    parallel_angle_max: float = setting(
        0.09, 'lines that differ more in direction are not parallel', unit='rad', minimum=0.01, maximum=0.5
    )
    parallel_length_min: float = setting(
        16.0, 'shorter parallel lines are left out', unit='px', minimum=4.0, maximum=1000.0
    )
    parallel_width_max: float = setting(
        120.0, 'parallel lines farther apart are left out', unit='px', minimum=2.0, maximum=2000.0
    )
    parallel_overlap_min: float = setting(
        0.6, 'part of the longer of two parallel lines beside which the other runs', minimum=0.1, maximum=1.0
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
        0.45, 'part of the outline of an ellipse that must be seen', minimum=0.1, maximum=1.0
    )
