import numpy as np
import pytest
from floor_views import MOUNT, random_floor
from scipy.spatial import cKDTree
from simulated_survey import (
    POSITION,
    SETTINGS,
    Drive,
    build_submaps_of,
    drive_over,
    errors,
    lane_poses,
    seen_dots,
    survey,
)  # fmt: skip

from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.floor_survey import SurveyResult, estimate_priors
from floor_localizer.core.survey.map_comparison import compare
from shirube_core.geometry import SE2

SIZE = (0.45, 0.33)
FLOOR = random_floor(1, SIZE)


@pytest.fixture(scope='module')
def drive() -> Drive:
    return drive_over(FLOOR, lane_poses(SIZE), spurious=1)


@pytest.fixture(scope='module')
def result(drive) -> SurveyResult:
    return survey(drive)


def test_lanes_become_one_map_without_spurious_dots_seen_once(drive, result):
    assert len(result.images) == len(drive.images)
    assert errors(drive, result).max() < 0.0004
    found = compare(drive.floor, result.dot_map)
    assert found.rms < 0.0002
    assert abs(found.scale - 1.0) < 0.002
    assert len(found.missing) < 0.04 * len(drive.floor)
    # One false dot per image; those in the outer strip, which only one image sees, are kept.
    assert result.spurious_count > 0.5 * len(drive.images)
    assert len(found.extra) < 0.2 * len(drive.images)
    assert (result.counts[result.counts > 1]).size > 0.8 * len(result.dot_map)


def test_short_submaps_have_loop_closures_to_the_neighbouring_lane(drive):
    # With submaps of a whole lane each, as above, neighbouring lanes are consecutive and there is no loop closure.
    settings = SurveySettings(submap_length=2.0)
    result, count = survey(drive, settings=settings), len(build_submaps_of(drive.images, settings))
    assert count > 6
    assert result.loop_closures >= count // 2
    assert errors(drive, result).max() < 0.0004


@pytest.mark.parametrize('sway', [0.0, 0.5])
def test_priors_distinguish_a_stiff_robot_from_a_swaying_one_which_bends_the_map_but_little(sway):
    result = survey(drive_over(FLOOR, lane_poses(SIZE), sway=sway))
    priors = estimate_priors(result.states, POSITION, SETTINGS)
    true = sway * np.array([0.02, 0.0175]) / np.sqrt(2.0)
    priors_found = np.array([priors.scale, priors.tilt])
    assert np.all(priors_found < 1.5 * true + 0.0003)
    assert np.all(priors_found > 0.6 * true)
    found = compare(FLOOR, result.dot_map)
    assert abs(found.scale - 1.0) < 0.01
    assert found.rms < 0.0015
    assert np.sqrt(np.mean(np.concatenate([each for _, each in result.residuals]) ** 2)) < 0.00006


def test_a_loop_is_closed_despite_odometry_drift():
    corners = [(0.07, 0.07), (0.43, 0.07), (0.43, 0.43), (0.07, 0.43), (0.07, 0.09)]
    truth, yaws = [], np.pi / 2 * np.arange(4)
    for start, end, yaw in zip(corners, corners[1:], yaws):
        # The robot turns on the spot below its camera in steps of 0.4 rad.
        truth += [SE2(*start, yaw - s * np.pi / 2) for s in (0.75, 0.5, 0.25) if yaw]
        way = np.subtract(end, start)
        truth += [SE2(*(start + s * way), yaw) for s in np.arange(0.0, 1.0, 0.03 / np.hypot(*way))]
    drive = drive_over(random_floor(3, (0.5, 0.5)), [pose @ SE2(*MOUNT.xyz[:2], 0.0).inverse() for pose in truth])
    result = survey(drive)
    assert result.loop_closures >= 1
    assert errors(drive, result).max() < 0.001


def test_an_extended_map_keeps_its_dots(drive):
    old = drive.floor.points[:, 0] < 0.22
    existing = DotMap(drive.floor.points[old], drive.floor.diameters[old])
    result = survey(drive, existing)
    np.testing.assert_array_equal(result.dot_map.points[: old.sum()], existing.points)
    new = result.dot_map.points[old.sum() :]
    distance, which = cKDTree(drive.floor.points).query(new)
    # A fifth of the new floor is in no image; all dots that are in one are on the map.
    wanted = np.flatnonzero(seen_dots(drive) & ~old)
    assert np.isin(wanted, which[distance < 0.0005]).mean() > 0.99
    # In the frame of the existing map, without registpriors_foundn.
    assert np.sqrt(np.mean(distance[distance < 0.003] ** 2)) < 0.0005
    assert np.mean(distance < 0.003) > 0.97


def test_images_of_different_floors_do_not_overlap(drive):
    views = [drive_over(random_floor(10 + k, SIZE), [drive.truth[k]], seed=k) for k in range(8)]
    with pytest.raises(FloorLocalizerError, match=r'no overlap: only .* matches none before it'):
        survey(Drive(drive.floor, [view.images[0] for view in views], drive.truth[:8]))


def test_a_map_of_another_floor_is_not_extended(drive):
    with pytest.raises(FloorLocalizerError, match='show nothing of the map that is to be extended'):
        survey(drive, random_floor(7, SIZE))


def test_a_floor_that_repeats_makes_no_wrong_loop():
    """Two halves with the same dots: the robot drives on the left, then far away on the right."""
    half = random_floor(2, (0.4, 0.2)).points
    floor = DotMap(np.vstack([half, half + np.array([0.4, 0.0])]), np.full(2 * len(half), 0.0025))
    drive = drive_over(floor, lane_poses((0.8, 0.2)))
    assert errors(drive, survey(drive)).max() < 0.002
