"""A survey in many blocks against one block and against dense linear algebra."""

from dataclasses import replace

import numpy as np
import pytest
from floor_views import random_floor
from simulated_survey import POSITION, SETTINGS, Drive, drive_over, lane_poses, survey

from floor_localizer.core.independent_tasks import InProcessRunner
from floor_localizer.core.survey.adjustment.block_partition import BlockPartitioner, Tile, split_into_tiles, store_boxes
from floor_localizer.core.survey.adjustment.bundle_adjustment import SuspensionPriors, bundle_adjust_blocks
from floor_localizer.core.survey.adjustment.observations import (
    ObservationBlock,
    ObservationBlocks,
    collect_observations,
    merge_observations,
    project_observations,
    project_rays_to_map,
)
from floor_localizer.core.survey.adjustment.surveyed_dots import fix_dots, store_existing_dots
from floor_localizer.core.survey.array_store import MemoryArrayStore
from floor_localizer.core.survey.survey_image import SurveyImage
from floor_localizer.files.array_file import DiskArrayStore
from floor_localizer.survey_files.survey_images import pack_images
from shirube_core.geometry import SE2

PRIORS = SuspensionPriors(POSITION, 0.001, 0.001)
MERGE_DISTANCE = 0.0008


@pytest.fixture(scope='module')
def drive() -> Drive:
    return drive_over(random_floor(1, (0.45, 0.33)), lane_poses((0.45, 0.33)), sway=0.1)


@pytest.fixture(scope='module')
def states(drive: Drive) -> np.ndarray:
    return survey(drive).states


def partition(drive, states, most, merge_distance=MERGE_DISTANCE, store=None) -> ObservationBlocks:
    images, sigma, store = np.arange(len(drive.images)), SETTINGS.dot_sigma, store or MemoryArrayStore()
    partitioner = BlockPartitioner(drive.images, images, POSITION, sigma, store, InProcessRunner(), most)
    return partitioner.partition(states, merge_distance)


def observations_by_dot(blocks: ObservationBlocks) -> set[frozenset[tuple[float, ...]]]:
    """Return each dot as the set of its observations."""
    dots = {}
    for number, block in enumerate(blocks):
        seen = block.observations
        for dot, *observation in zip(seen.dot.tolist(), seen.image.tolist(), seen.directions.tolist()):
            dots.setdefault((number, dot), set()).add((observation[0], *observation[1]))
    return set(map(frozenset, dots.values()))


@pytest.mark.parametrize('merge_distance', [MERGE_DISTANCE, 0.0035])
def test_dots_are_those_of_all_observations_at_once(drive, states, merge_distance):
    # With the larger merge distance, clusters span several tiles before they are split.
    observations = collect_observations(drive.images, np.arange(len(states)), SETTINGS.dot_sigma)
    points = project_observations(observations, states, POSITION).points
    dot = merge_observations(points, observations.image, merge_distance)
    whole = ObservationBlock(replace(observations, dot=dot), np.empty((dot.max() + 1, 2)))
    blocks = partition(drive, states, 9, merge_distance)
    assert len(blocks) >= 8
    assert observations_by_dot(blocks) == observations_by_dot([whole])


def test_many_blocks_are_adjusted_as_one(drive, states, tmp_path):
    many, one = (
        bundle_adjust_blocks(partition(drive, states, most, store=store), states, PRIORS, InProcessRunner())
        for most, store in ((9, DiskArrayStore(tmp_path / 'shelf')), (10_000, MemoryArrayStore()))
    )
    assert np.abs(many - states).max() > 1e-6
    np.testing.assert_allclose(many, one, rtol=0.0, atol=1e-10)


def test_a_step_is_that_of_dense_equations_with_all_dots(drive, states):
    """Few images and no residual beyond the Huber threshold, so that the weights follow from the sigmas."""
    few = Drive(drive.floor, drive.images[:14], drive.truth[:14])
    blocks, start = partition(few, states[:14], 4), states[:14]
    for number, block in enumerate(blocks):
        observations = replace(block.observations, sigmas=20.0 * block.observations.sigmas)
        blocks.put(number, ObservationBlock(observations, block.fixed_dots))
    rows, values, count = [], [], 6 * 14 + 2 * sum(len(block.fixed_dots) for block in blocks)
    dots_before = 6 * 14
    for block in blocks:
        observations = block.observations
        points = project_rays_to_map(observations.directions, POSITION, start[observations.image])
        dots = range(len(block.fixed_dots))
        means = np.array([points[observations.dot == dot].mean(axis=0) for dot in dots])
        for k, image in enumerate(observations.image.tolist()):
            jacobian = np.zeros((2, count))
            for unknown in range(6):
                step = 1e-5 * (np.arange(6) == unknown)
                ahead, behind = (
                    project_rays_to_map(observations.directions[[k]], POSITION, start[[image]] + each)[0]
                    for each in (step, -step)
                )
                jacobian[:, 6 * image + unknown] = (ahead - behind) / 2e-5
            residual = points[k] - means[observations.dot[k]]
            jacobian[:, 6 * image + 3] -= residual
            jacobian[:, dots_before + 2 * observations.dot[k] + np.arange(2)] = -np.eye(2)
            rows += list(jacobian / observations.sigmas[k])
            values += list(residual / observations.sigmas[k])
        dots_before += 2 * len(block.fixed_dots)
    sigmas = np.tile([np.inf, np.inf, np.inf, PRIORS.scale, PRIORS.tilt, PRIORS.tilt], 14)
    sigmas[:3] = 1e-7
    prior = np.zeros((len(sigmas), count))
    prior[:, : len(sigmas)] = np.diag(1.0 / sigmas)
    pull = np.where(np.arange(len(sigmas)) % 6 < 3, 0.0, start.ravel() / sigmas)
    step = -np.linalg.lstsq(np.vstack([*rows, *prior]), np.concatenate([values, pull]), rcond=None)[0]
    found = bundle_adjust_blocks(blocks, start, PRIORS, InProcessRunner(), iterations=1) - start
    assert np.abs(found).max() > 1e-5
    np.testing.assert_allclose(found.ravel(), step[: 6 * 14], atol=2e-4 * np.abs(found).max())


def test_a_dot_of_the_existing_map_is_matched_once(drive, states):
    many, one = partition(drive, states, 9), partition(drive, states, 10_000)
    old = some_dots(states, one) + 0.0001
    for blocks in (many, one):
        existing = store_existing_dots(old, blocks.store)
        fix_dots(blocks, states, POSITION, existing, MERGE_DISTANCE, InProcessRunner())
    kept = [np.concatenate([block.fixed_dots[block.is_fixed] for block in blocks]) for blocks in (many, one)]
    assert len(kept[0]) == len(np.unique(kept[0], axis=0)) > 0.9 * len(old)
    assert {tuple(dot) for dot in kept[0]} == {tuple(dot) for dot in kept[1]}


def some_dots(states: np.ndarray, blocks: ObservationBlocks) -> np.ndarray:
    observations = blocks[0].observations
    points = project_rays_to_map(observations.directions, POSITION, states[observations.image])
    return np.array([points[observations.dot == dot][0] for dot in range(0, len(blocks[0].fixed_dots), 5)])


def views_of_a_dot_each(points: np.ndarray) -> list[SurveyImage]:
    """Return images of one dot each, all from the map's origin."""
    directions = np.column_stack([points - POSITION[:2], np.full(len(points), -POSITION[2])])
    one, home = np.full(1, 0.0001), SE2(0.0, 0.0, 0.0)
    return [SurveyImage(str(k), home, directions[[k]], points[[k]], one, 20.0 * one) for k in range(len(points))]


def test_a_cluster_over_many_tiles_is_one_dot():
    points = np.column_stack([0.0005 * np.arange(60), np.zeros(60)])
    row = Drive(None, views_of_a_dot_each(points), [])
    blocks = partition(row, np.zeros((60, 6)), 2)
    assert len(blocks) == 32
    assert [len(block.observations.image) for block in blocks if len(block.fixed_dots)] == [60]


def test_of_dots_in_several_blocks_the_nearest_is_fixed():
    points = np.array([[0.0, 0.0003], [0.0, -0.0001], [0.0, 0.0002]])
    blocks = ObservationBlocks(MemoryArrayStore(), 3)
    for number in range(3):
        view = views_of_a_dot_each(points)[number : number + 1]
        observations = replace(collect_observations(view, np.array([number]), 0.0), dot=np.zeros(1, np.int64))
        blocks.put(number, ObservationBlock(observations, np.full((1, 2), np.nan)))
    old = store_existing_dots(np.zeros((1, 2)), blocks.store)
    fix_dots(blocks, np.zeros((3, 6)), POSITION, old, MERGE_DISTANCE, InProcessRunner())
    assert [bool(block.is_fixed[0]) for block in blocks] == [False, True, False]


def test_packed_images_are_the_same_images(drive, tmp_path):
    packed = pack_images(tmp_path / 'images.bin', drive.images)
    for k in (0, 7, -1):
        for name in ('directions', 'points', 'sigmas', 'diameters', 'T_odom_base', 'name'):
            np.testing.assert_equal(getattr(packed[k], name), getattr(drive.images[k], name))
    assert [image.name for image in packed[3:6]] == [image.name for image in drive.images[3:6]]
    assert len(packed) == len(list(packed)) == len(drive.images)


@pytest.mark.parametrize('count', [1, 31, 32, 33, 500])
def test_exactly_the_images_whose_boxes_overlap_a_tile_are_found(count):
    rng = np.random.default_rng(count)
    centres = np.cumsum(rng.normal(0.0, 0.1, (count, 2)), axis=0)  # along a drive
    sizes = rng.uniform(0.0, 0.1, (count, 2))
    lower, upper = centres - sizes, centres + sizes
    found = store_boxes(np.stack([lower, upper], axis=1), MemoryArrayStore())
    for tile in split_into_tiles(centres, 7):
        for each in (tile, tile.expanded(-0.05)):
            meets = np.all((lower < each.upper) & (upper >= each.lower), axis=1)
            assert found.overlapping_images(each).tolist() == np.flatnonzero(meets).tolist()
    assert len(found.overlapping_images(Tile(np.full(2, np.inf), np.full(2, -np.inf)))) == 0
