"""Settings of the localizer and of the image processing, in groups."""

import math
from dataclasses import dataclass, field

from shirube_core.settings import setting, tunable


@dataclass(frozen=True)
class EdgeSettings:
    """Edge detection and linking: spatial filter, hysteresis thresholds, noise removal, polylines.

    Non-maximum suppression makes every edge one pixel wide; ``thinning`` selects the paper's thinning instead.
    """

    filter_sigma: float = setting(1.0, 'standard deviation of the Gaussian derivative filter', 'px', (0.5, 5.0))
    threshold: float = setting(
        6.0,
        'upper hysteresis threshold: gradient that a segment must reach at one point [grey levels / px]',
        limits=(0.5, 200.0),
    )
    continuation: float = setting(0.4, 'lower hysteresis threshold as a fraction of threshold', limits=(0.1, 1.0))
    thinning: float = setting(
        0.0,
        'maximum passes of thinning of the binary image, as in the paper; 0: non-maximum suppression',
        limits=(0.0, 20.0),
    )
    length_min: float = setting(8.0, 'minimum segment length; shorter segments are noise', 'px', (2.0, 1000.0))
    bend_tolerance: float = setting(0.8, 'tolerance of the polyline approximation (Douglas-Peucker)', 'px', (0.3, 10.0))


@dataclass(frozen=True)
class PrimitiveSettings:
    """Settings of the four detectors; lengths are in image pixels."""

    side_length_min: float = setting(8.0, 'minimum length of a line segment', 'px', (3.0, 1000.0))
    side_gap_max: float = setting(
        0.5, 'longest gap to join, as a fraction of both line segments together', limits=(0.0, 2.0)
    )
    side_offset_max: float = setting(1.5, 'largest offset of joined line segments across the line', 'px', (0.2, 10.0))
    corner_gap_max: float = setting(4.0, 'largest gap between an arm of a corner and the vertex', 'px', (1.0, 50.0))
    corner_angle_min: float = setting(0.35, 'smallest angle between the arms of a corner', 'rad', (0.05, 1.5))
    hidden_corner_max: float = setting(
        30.0, 'largest gap between a side of a quadrilateral and an occluded corner', 'px', (1.0, 300.0)
    )
    side_seen_min: float = setting(0.3, 'smallest visible fraction of each side of a quadrilateral', limits=(0.05, 1.0))
    outline_seen_min: float = setting(
        0.6, 'smallest visible fraction of the outline of a quadrilateral', limits=(0.1, 1.0)
    )
    parallel_angle_max: float = setting(0.09, 'largest angle between parallel lines', 'rad', (0.01, 0.5))
    parallel_length_min: float = setting(16.0, 'minimum length of parallel lines', 'px', (4.0, 1000.0))
    parallel_width_max: float = setting(120.0, 'largest distance between parallel lines', 'px', (2.0, 2000.0))
    parallel_overlap_min: float = setting(
        0.6, 'smallest overlap of parallel lines, as a fraction of the longer', limits=(0.1, 1.0)
    )
    ellipse_axis_min: float = setting(5.0, 'smallest semi-axis of an ellipse', 'px', (2.0, 1000.0))
    ellipse_axis_max: float = setting(300.0, 'largest semi-axis of an ellipse', 'px', (5.0, 5000.0))
    ellipse_flatness_min: float = setting(0.2, 'smallest ratio of the axes of an ellipse', limits=(0.05, 1.0))
    ellipse_seen_min: float = setting(0.45, 'smallest visible fraction of the outline of an ellipse', limits=(0.1, 1.0))


@tunable()
@dataclass(frozen=True)
class SearchSettings:
    """Search region of the pose, and acceptance thresholds of a target."""

    distance_max: float = setting(
        0.8, 'maximum distance of the robot from the taught pose', 'm', (0.05, 10.0), former_name='reach'
    )
    yaw_max: float = setting(
        math.radians(45.0),
        'maximum yaw of the robot relative to the taught pose',
        'rad',
        (0.02, 1.2),
        former_name='turn',
    )
    window: float = setting(
        12.0,
        'search window around the predicted pixel of a primitive, plus a fraction of its distance from the first one',
        'px',
        (2.0, 100.0),
    )
    found_fraction_min: float = setting(
        0.5,
        'minimum fraction of the primitives of a target that must be found',
        limits=(0.1, 1.0),
        former_name='seen_min',
    )
    detection_probability: float = setting(
        0.8, 'probability that a visible primitive is detected', limits=(0.1, 0.99), former_name='found_probability'
    )
    log_likelihood_ratio_min: float = setting(
        4.0,
        'minimum log-likelihood ratio against chance for accepting a pose hypothesis',
        limits=(0.0, 100.0),
        former_name='evidence_min',
    )
    margin: float = setting(
        4.0,
        'minimum difference of the log-likelihood ratio to the runner-up; otherwise the result is ambiguous',
        limits=(0.0, 100.0),
    )


REPROJECTION, CLOSED_FORM = 'reprojection', 'closed_form'


@tunable()
@dataclass(frozen=True)
class PlaceSettings:
    """Settings of the displacement estimate."""

    method: str = setting(
        REPROJECTION,
        "minimization of the reprojection error in both images, or the paper's closed form on 3D points",
        choices=(REPROJECTION, CLOSED_FORM),
    )
    points_min: int = setting(
        2, 'minimum number of points for a pose; at least three if some are outliers', limits=(2, 100)
    )
    pixel_sigma: float = setting(
        0.05, 'calibration error, standard deviation along each axis of each image', 'px', (0.0, 10.0)
    )
    bias_sigma: float = setting(
        0.05,
        'systematic error of disparities and rows that all points of a pair share, standard deviation',
        'px',
        (0.001, 2.0),
    )
    tilt_sigma: float = setting(
        0.002,
        'standard deviation of the roll and pitch prior; 0 fixes them, 0.5 estimates them from the points',
        'rad',
        (0.0, 0.5),
    )
    gate_sigmas: float = setting(
        5.0, 'points with a larger Mahalanobis distance are rejected as outliers', limits=(2.0, 20.0)
    )
    position_sigma_max: float = setting(0.1, 'maximum standard deviation of a published position', 'm', (0.001, 10.0))


@dataclass(frozen=True)
class PairSettings:
    """Rectification and synchronization of the image topics."""

    rectify: bool = setting(False, 'whether to rectify raw input images by their camera_info')
    approximate_sync: bool = setting(
        False, 'whether to pair images with slightly different stamps; otherwise stamps must be equal'
    )
    approximate_sync_tolerance_seconds: float = setting(
        0.01,
        'largest stamp difference of a pair with approximate_sync; less than half the frame interval',
        's',
        (0.0, 1.0),
    )
    queue_size: int = setting(5, 'queue size per camera for synchronization', limits=(1, 1000))

    @property
    def tolerance_ns(self) -> int:
        """Largest stamp difference of a pair [ns]."""
        return round(self.approximate_sync_tolerance_seconds * 1e9) if self.approximate_sync else 0


LIKELIHOOD, PAPER = 'likelihood', 'paper'
SHAPES, FEATURES, BOTH = 'shapes', 'features', 'both'


@dataclass(frozen=True)
class LandmarkSettings:
    """Settings of the target search and of the displacement estimate, in groups."""

    mode: str = setting(
        LIKELIHOOD,
        'search by the likelihood of pose hypotheses in the whole images; or as in the paper by the procedure tree in '
        'windows, without surroundings and patches, with the closed form',
        choices=(LIKELIHOOD, PAPER),
    )
    method: str = setting(
        BOTH,
        'find and measure the taught shapes, the features of the whole taught view, or both; paper mode uses shapes',
        choices=(SHAPES, FEATURES, BOTH),
    )
    search: SearchSettings = field(default_factory=SearchSettings)
    place: PlaceSettings = field(default_factory=PlaceSettings)
