import numpy as np
import pytest
from floor_views import random_floor
from scipy.spatial import cKDTree
from simulated_survey import (
    OUTLINE,
    POSITION,
    SETTINGS,
    Drive,
    build_submaps_of,
    drive_over,
    errors,
    lane_poses,
    seen_dots,
    small_floor,
    survey,
)

from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.array_store import MemoryArrayStore
from floor_localizer.core.survey.floor_survey import estimate_priors, survey_floor
from floor_localizer.core.survey.map_comparison import compare

SIZE = (0.45, 0.33)


@pytest.fixture(scope='module')
def drive() -> Drive:
    return drive_over(small_floor(), lane_poses(SIZE), spurious=1)


def test_lanes_become_one_map(drive):
    result = survey(drive)
    assert len(result.images) == len(drive.images)
    assert errors(drive, result).max() < 0.0004
    found = compare(drive.floor, result.dot_map)
    assert found.rms < 0.0002
    assert abs(found.scale - 1.0) < 0.002
    assert len(found.missing) < 0.04 * len(drive.floor)


def test_short_submaps_have_loop_closures_to_the_neighbouring_lane(drive):
    # With submaps of a whole lane each, as above, neighbouring lanes are consecutive and there is no loop closure.
    settings = SurveySettings(submap_length=2.0)
    submaps = build_submaps_of(drive.images, settings)
    result = survey_floor(drive.images, submaps, OUTLINE, POSITION, settings, MemoryArrayStore())
    assert len(submaps) > 6
    assert result.loop_closures >= len(submaps) // 2
    assert errors(drive, result).max() < 0.0004


def test_spurious_dots_seen_once_are_dropped(drive):
    result = survey(drive)
    # One false dot per image; those in the outer strip, which only one image sees, are kept.
    assert result.spurious_count > 0.5 * len(drive.images)
    assert len(compare(drive.floor, result.dot_map).extra) < 0.2 * len(drive.images)
    assert (result.counts[result.counts > 1]).size > 0.8 * len(result.dot_map)


def test_priors_distinguish_a_stiff_robot_from_a_swaying_one():
    for sway in (0.0, 0.5):
        result = survey(drive_over(small_floor(), lane_poses(SIZE), sway=sway))
        priors = estimate_priors(result.states, POSITION, SETTINGS)
        true = sway * np.array([0.02, 0.0175]) / np.sqrt(2.0)
        found = np.array([priors.scale, priors.tilt])
        assert np.all(found < 1.5 * true + 0.0003)
        assert np.all(found > 0.6 * true)


def test_a_swaying_robot_bends_the_map_but_little():
    drive = drive_over(small_floor(), lane_poses(SIZE), sway=0.5)
    result = survey(drive)
    found = compare(drive.floor, result.dot_map)
    assert abs(found.scale - 1.0) < 0.01
    assert found.rms < 0.0015
    assert np.sqrt(np.mean(np.concatenate([each for _, each in result.residuals]) ** 2)) < 0.00006


def test_a_loop_is_closed_despite_odometry_drift():
    size = (0.5, 0.5)
    corners = [(0.07, 0.07), (0.43, 0.07), (0.43, 0.43), (0.07, 0.43), (0.07, 0.09)]
    poses = []
    for start, end in zip(corners, corners[1:]):
        way = np.subtract(end, start)
        for share in np.arange(0.0, 1.0, 0.03 / np.hypot(*way)):
            x, y = np.array(start) + share * way
            poses.append((x, y, np.arctan2(way[1], way[0])))
    from floor_views import MOUNT  # noqa: PLC0415

    from shirube_core.geometry import SE2  # noqa: PLC0415

    # The robot turns on the spot below its camera in steps of 0.4 rad.
    truth = []
    for k, (x, y, yaw) in enumerate(poses):
        if k and abs(yaw - poses[k - 1][2]) > 0.1:
            turn = (yaw - poses[k - 1][2] + np.pi) % (2 * np.pi) - np.pi
            truth += [SE2(float(x), float(y), float(poses[k - 1][2] + turn * s)) for s in (0.25, 0.5, 0.75)]
        truth.append(SE2(float(x), float(y), float(yaw)))
    truth = [pose @ SE2(*MOUNT.xyz[:2], 0.0).inverse() for pose in truth]
    drive = drive_over(random_floor(3, size), truth)
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
    # In the frame of the existing map, without registration.
    assert np.sqrt(np.mean(distance[distance < 0.003] ** 2)) < 0.0005
    assert np.mean(distance < 0.003) > 0.97


def test_images_of_different_floors_do_not_overlap(drive):
    images = [
        drive_over(small_floor(10 + k), [pose], seed=k).images[0] for k, pose in enumerate(drive.truth[:8])
    ]
    with pytest.raises(FloorLocalizerError, match=r'no overlap: only .* matches none before it'):
        survey(Drive(drive.floor, images, drive.truth[:8]))


def test_a_map_of_another_floor_is_not_extended(drive):
    with pytest.raises(FloorLocalizerError, match='show nothing of the map that is to be extended'):
        survey(drive, small_floor(7))


def test_a_floor_that_repeats_makes_no_wrong_loop():
    """Two halves with the same dots: the robot drives on the left, then far away on the right."""
    half = small_floor(2, (0.4, 0.2)).points
    floor = DotMap(np.vstack([half, half + np.array([0.4, 0.0])]), np.full(2 * len(half), 0.0025))
    poses = lane_poses((0.8, 0.2))
    result = survey(drive_over(floor, poses))
    assert errors(drive_over(floor, poses), result).max() < 0.002
