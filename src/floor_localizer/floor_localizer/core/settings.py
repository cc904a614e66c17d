"""The settings of dot extraction, matching, tracking and survey; all that depends on the floor is computed."""

from dataclasses import dataclass, field

from shirube_core.settings import setting, tunable


@dataclass(frozen=True)
class PoleStarSettings:
    """Settings of the paper's matching; values that it does not give have defaults for its floor and 1 px of noise."""

    radius: float = setting(0.09, 'pole-star radius', 'm', (0.001, 10.0))
    quantum: float = setting(0.0005, 'quantization step of distances', 'm', (1e-6, 0.1))
    vote_tolerance: float = setting(
        0.00075, 'maximum difference between a distance and those it votes for', 'm', (1e-6, 0.1)
    )
    pairs_per_region: int = setting(
        90, 'expected number of random candidates in a region, over all image dots', limits=(1, 1000)
    )
    grid_pitch: float = setting(0.06, 'distance between the nodes where overlap is counted', 'm', (0.001, 10.0))
    overlap_min: int = setting(5, 'minimum number of image dots of a region', limits=(2, 1000))
    congruence_tolerance: float = setting(0.0016, 'maximum difference of two equal distances', 'm', (1e-6, 0.1))
    congruent_min: int = setting(5, 'minimum number of congruent pairs of a pose', limits=(2, 1000))
    address_block: float = setting(0.0028, 'side of a block of the address matrix', 'm', (1e-4, 0.1))
    match_rate_min: float = setting(0.31, 'minimum match rate of a pose', limits=(0.0, 1.0))


@tunable(fixed=('matcher',))
@dataclass(frozen=True)
class LocalizerSettings:
    """Settings of the matching."""

    matcher: str = setting(
        'constellation',
        "search of the whole map: by constellations of six dots, or by the paper's pole star",
        choices=('constellation', 'pole_star'),
    )
    match_rate_min: float = setting(
        0.25, 'minimum fraction of the dots in view that match the map (paper: reference match rate)', limits=(0.0, 1.0)
    )
    chance_alignments_max: float = setting(
        1e-3, 'maximum expected number of equally good chance alignments of an accepted pose', limits=(1e-12, 0.1)
    )
    scale_tolerance: float = setting(
        0.05, 'maximum relative error of the height of the camera above the floor', limits=(0.001, 0.15)
    )
    tilt_tolerance: float = setting(0.035, 'maximum tilt (roll, pitch) of the robot', 'rad', (0.001, 0.1))
    map_sigma: float = setting(0.00005, "standard deviation of the map's dots along each axis", 'm', (0.0, 0.01))
    cells_max: int = setting(
        400000, 'maximum number of index cells opened for one view before the pair search', limits=(0, 100000000)
    )
    pairs_max: int = setting(
        24,
        'maximum number of pairs of one view that are matched to the whole map if no constellation matched',
        limits=(0, 10000),
    )
    pole_star: PoleStarSettings = field(default_factory=PoleStarSettings)


@tunable()
@dataclass(frozen=True)
class TrackerSettings:
    """Settings of the pose prediction and of the search between images."""

    odometry_error: float = setting(
        0.05, 'error of the odometry as a fraction of the distance driven, and in rad/m', limits=(0.0, 1.0)
    )
    still_radius: float = setting(
        0.003, 'search radius around the predicted pose with odometry, without motion', 'm', (0.0001, 1.0)
    )
    still_turn: float = setting(
        0.02, 'yaw tolerance of the predicted pose with odometry, without motion', 'rad', (0.0001, 3.2)
    )
    acceleration_max: float = setting(
        3.0, 'maximum acceleration of the robot, used without odometry', 'm/s^2', (0.01, 50.0)
    )
    turn_acceleration_max: float = setting(
        10.0, 'maximum angular acceleration, used without odometry', 'rad/s^2', (0.01, 500.0)
    )
    prior_radius_max: float = setting(
        0.3, 'maximum radius of a prior; a less certain prediction is ignored', 'm', (0.01, 10.0)
    )
    initialpose_is_strict: bool = setting(
        True,
        'whether poses outside the area of initialpose are rejected; false, for areas from another localizer: the '
        'whole map is searched if there is no pose inside',
    )
    chance_alignments_alone_max: float = setting(
        1e-6,
        'a first pose with more expected chance alignments must be confirmed by the next view',
        limits=(1e-12, 0.1),
    )
    thorough_interval: float = setting(
        1.0, 'period of thorough searches of the whole map while the robot is lost', 's', (0.0, 60.0)
    )
    thorough_effort: float = setting(
        0.3, 'fraction of cells_max and pairs_max for a thorough search', limits=(0.0, 1.0)
    )
    usual_effort: float = setting(
        0.04, 'the same for every other image that does not match within the prior', limits=(0.0, 1.0)
    )
    joined_views: int = setting(
        4, 'maximum number of views merged by odometry if one view has too few dots', limits=(1, 20)
    )


@tunable()
@dataclass(frozen=True)
class DotDetectorSettings:
    """Criteria for a dot. Lengths are in pixels or fractions of the typical dot of the current image."""

    polarity: str = setting(
        'auto',
        'which dots are detected: darker or lighter than the floor, any that differ in brightness or colour, '
        'or auto to choose one of these for each image',
        choices=('auto', 'dark', 'light', 'any'),
    )
    minimum_diameter: float = setting(3.0, 'minimum diameter of a dot', 'px', (2.0, 500.0))
    maximum_diameter: float = setting(
        0.0, 'maximum diameter of a dot; 0 for 5 % of the longer image side, at least 25 px', 'px', (0.0, 1000.0)
    )
    minimum_relative_diameter: float = setting(
        0.4, 'minimum diameter of a dot as a fraction of the typical diameter', limits=(0.0, 1.0)
    )
    minimum_relative_contrast: float = setting(
        0.3, 'minimum contrast of a pixel of a dot as a fraction of the typical contrast', limits=(0.1, 0.8)
    )
    noise_sigmas: float = setting(
        5.0, 'minimum contrast of a pixel of a dot in standard deviations of the floor', limits=(2.0, 20.0)
    )
    maximum_elongation: float = setting(
        4.0, 'maximum ratio of length to width, corrected for motion blur', limits=(1.5, 100.0)
    )

    def largest_diameter(self, width: int, height: int) -> float:
        """Return the maximum diameter of a dot in an image of this size [px]."""
        return self.maximum_diameter or max(25.0, 0.05 * max(width, height))


@dataclass(frozen=True)
class SurveySettings:
    """Accuracy of odometry, camera and floor, and how the survey is divided."""

    odometry_position_tolerance: float = setting(
        0.004, 'position error of odometry between two images', 'm', (0.0001, 0.1), former_name='odometry_radius'
    )
    odometry_yaw_tolerance: float = setting(
        0.03, 'yaw error of odometry between two images', 'rad', (0.0001, 0.5), former_name='odometry_turn'
    )
    odometry_error: float = setting(
        0.05, 'growth of these errors per metre driven, in m/m and rad/m', limits=(0.0, 0.5)
    )
    image_step: float = setting(
        0.35, 'motion between two used images as a fraction of the view width', limits=(0.0, 0.9)
    )
    submap_length: float = setting(
        4.0, 'length of a submap in view widths', limits=(2.0, 20.0), former_name='piece_length'
    )
    scale_sigma: float = setting(
        0.01, 'relative variation of the camera height, standard deviation', limits=(0.0001, 0.05)
    )
    tilt_sigma: float = setting(0.01, 'tilt of the robot body, standard deviation', 'rad', (0.0001, 0.05))
    dot_sigma: float = setting(
        0.00003, 'standard deviation of a dot on the floor, in addition to image noise', 'm', (0.0, 0.001)
    )
    merge_distance: float = setting(
        0.0006, 'observations closer than this are merged into one dot', 'm', (0.0001, 0.005), former_name='same_dot'
    )
    chance_alignments_max: float = setting(
        1e-6,
        'largest expected number of equally good matches by chance, for a match to be accepted',
        limits=(1e-12, 0.01),
        former_name='chance',
    )
