"""Observations of dots in images, projected to the map, in groups of images and in blocks of dots in an array store."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from floor_localizer.core.arrays import Booleans, Floats, Ints
from floor_localizer.core.independent_tasks import TaskRunner, run_indexed
from floor_localizer.core.survey.array_store import ArrayStore
from floor_localizer.core.survey.survey_image import SurveyImage, ViewOutline
from shirube_core.geometry import SE2

_MAX_SPLITS = 4


def merge_observations(points: Floats, image: Ints, merge_distance: float) -> Ints:
    """Merge observations into dots: single-linkage clusters of observations from different images.

    A cluster with two observations of one image, which are two dots, is split with half the merge distance.

    Args:
        points: observations on the map, shape (n, 2) [m].
        image: image of each observation, shape (n,).
        merge_distance: merge distance [m].

    Returns:
        the dot number of each observation, from 0 without gaps, shape (n,).
    """
    labels = np.arange(len(points))
    unassigned = np.arange(len(points))
    for _ in range(_MAX_SPLITS):
        if len(unassigned) == 0:
            break
        clusters = cluster_observations(points[unassigned], image[unassigned], merge_distance)
        is_consistent = ~_has_duplicates(clusters, image[unassigned])
        first = np.full(int(clusters.max(initial=-1)) + 1, -1)
        first[clusters[::-1]] = unassigned[::-1]
        labels[unassigned[is_consistent]] = first[clusters[is_consistent]]
        unassigned = unassigned[~is_consistent]
        merge_distance *= 0.5
    return np.unique(labels, return_inverse=True)[1].astype(np.int64)


def cluster_observations(points: Floats, image: Ints, merge_distance: float) -> Ints:
    """Return the cluster number of each observation; arguments as for `merge_observations`."""
    if len(points) == 0:
        return np.empty(0, dtype=np.int64)
    pairs = cKDTree(points).query_pairs(merge_distance, output_type='ndarray')
    pairs = pairs[image[pairs[:, 0]] != image[pairs[:, 1]]]
    links = sparse.coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    return connected_components(links, directed=False)[1].astype(np.int64)


def _has_duplicates(clusters: Ints, image: Ints) -> Booleans:
    """Return for each observation whether its cluster contains two observations of one image."""
    order = np.lexsort((image, clusters))
    same = (np.diff(clusters[order]) == 0) & (np.diff(image[order]) == 0)
    bad = np.zeros(int(clusters.max(initial=-1)) + 1, dtype=np.bool_)
    bad[clusters[order][1:][same]] = True
    return bad[clusters]


def count_expected_views(dots: Floats, states: Floats, outline: ViewOutline, margin: float) -> Ints:
    """Return the number of images that should have observed each dot, shape (m,).

    ``states`` are those of all images that may have observed any of them; in a border of the view as wide as ``margin``
    [m] a dot may be cut off.
    """
    counts = np.zeros(len(dots), dtype=np.int64)
    if len(dots) == 0:
        return counts
    tree = cKDTree(dots)
    for place, state in zip(outline.centres(states), states, strict=True):
        pose = SE2(*(float(value) for value in state[:3]))
        near = np.array(tree.query_ball_point(place, outline.radius), dtype=np.int64)
        counts[near[outline.contains(pose.inverse().transform(dots[near]), margin)]] += 1
    return counts


_BLOCKS_PER_TASK = 4  # blocks processed in one task: enough to hide the overhead of scheduling
_GROUP_SIZE = 32  # number of consecutive images that are stored and read together


@dataclass(frozen=True)
class Observations:
    """Observations of dots in images.

    Attributes:
        image: index of the image, shape (n,).
        dot: index of the dot, shape (n,); -1 before observations are merged into dots.
        directions: ray directions in the base frame of the level robot, shape (n, 3).
        sigmas: standard deviation on the floor along each axis, shape (n,) [m].
        diameters: observed diameters of the dots, shape (n,) [m].
    """

    image: Ints
    dot: Ints
    directions: Floats
    sigmas: Floats
    diameters: Floats

    @property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """All attributes, in order."""
        return self.image, self.dot, self.directions, self.sigmas, self.diameters

    def where(self, kept: Booleans) -> Observations:
        """Return the observations selected by a mask, shape (n,); the dots keep their indices."""
        return Observations(*(array[kept] for array in self.arrays))


@dataclass(frozen=True)
class ObservationBlock:
    """All observations of some dots, numbered in the block; positions of fixed dots, (m, 2) [m], NaN for the others."""

    observations: Observations
    fixed_dots: Floats

    @property
    def is_fixed(self) -> Booleans:
        """Whether each dot is fixed, shape (m,)."""
        return np.isfinite(self.fixed_dots[:, 0])


@dataclass(frozen=True)
class ObservationBlocks:
    """Blocks in an array store; blocks with neighbouring numbers are neighbours on the floor.

    Attributes:
        store: array store of the blocks.
        count: number of blocks; each must be written before it is read.
    """

    store: ArrayStore
    count: int

    def __len__(self) -> int:
        """Return the number of blocks."""
        return self.count

    def __getitem__(self, number: int) -> ObservationBlock:
        """Return a block."""
        *observations, fixed_dots = self.store.get('block', number)
        return ObservationBlock(Observations(*observations), fixed_dots)

    def __iter__(self) -> Iterator[ObservationBlock]:
        """Yield all blocks in order."""
        return (self[number] for number in range(self.count))

    def put(self, number: int, block: ObservationBlock) -> None:
        """Write or overwrite a block."""
        self.store.put('block', number, *block.observations.arrays, block.fixed_dots)
        self.store.put('members', number, np.unique(block.observations.image), np.array(block.is_fixed.any()))

    def for_each(self, runner: TaskRunner, task: Callable[..., None], *arguments: Any) -> None:
        """Call a task with the blocks, the arguments and the number of each block."""
        run_indexed(runner, partial(task, self, *arguments), self.count, _BLOCKS_PER_TASK)

    def observing_images(self, number: int) -> tuple[Ints, bool]:
        """Return the images that observe dots of a block, ascending, and whether any of its dots is fixed."""
        images, has_fixed = self.store.get('members', number)
        return images, bool(has_fixed)


def project_rays_to_map(directions: Floats, position: Floats, states: Floats) -> Floats:
    """Return the intersections p(state, d) of rays with the floor in the map frame, shape (n, 2) [m].

    ``directions``, shape (n, 3), are in the base frame of the level robot, ``states``, shape (n, 6), of the image of
    each.
    """
    x, y, yaw, scale, roll, pitch = states.T
    d = _tilt(directions.T, roll, pitch)
    o = _tilt(np.broadcast_to(position[:, None], d.shape), roll, pitch)
    ray_length = -(o[2] + position[2] * scale) / d[2]
    px, py = o[0] + ray_length * d[0], o[1] + ray_length * d[1]
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.column_stack([x + cos * px - sin * py, y + sin * px + cos * py])


def _tilt(vectors: Floats, roll: Floats, pitch: Floats) -> Floats:
    x, y, z = vectors
    y, z = np.cos(roll) * y - np.sin(roll) * z, np.sin(roll) * y + np.cos(roll) * z
    return np.stack([np.cos(pitch) * x + np.sin(pitch) * z, y, np.cos(pitch) * z - np.sin(pitch) * x])


@dataclass(frozen=True)
class ProjectedObservations:
    """Observations grouped by image, not yet assigned to dots, and their ``points`` in the map frame, (n, 2) [m]."""

    observations: Observations
    points: Floats

    def where(self, kept: Booleans) -> ProjectedObservations:
        """Return the observations selected by a mask, shape (n,)."""
        return ProjectedObservations(self.observations.where(kept), self.points[kept])


def collect_observations(images: Sequence[SurveyImage], numbers: Ints, dot_sigma: float) -> Observations:
    """Return the observations of images with some numbers, shape (j,), not yet assigned to dots.

    ``dot_sigma`` is the standard deviation of a dot on the floor, in addition to image noise [m].
    """
    image = np.repeat(numbers, np.array([len(each) for each in images], dtype=np.int64))
    directions = np.concatenate([np.empty((0, 3)), *(each.directions for each in images)])
    sigmas = np.hypot(np.concatenate([np.empty(0), *(each.sigmas for each in images)]), dot_sigma)
    diameters = np.concatenate([np.empty(0), *(each.diameters for each in images)])
    return Observations(image, np.full(len(image), -1), directions, sigmas, diameters)


def project_observations(observations: Observations, states: Floats, position: Floats) -> ProjectedObservations:
    """Project observations to the map by the states of their images."""
    return ProjectedObservations(
        observations, project_rays_to_map(observations.directions, position, states[observations.image])
    )


_EMPTY = collect_observations((), np.empty(0, dtype=np.int64), 0.0)


@dataclass(frozen=True)
class StoredObservations:
    """Observations in groups of consecutive images, not yet assigned to dots, in an array store."""

    store: ArrayStore
    images: int

    @property
    def group_count(self) -> int:
        """Number of groups of consecutive images."""
        return -(-self.images // _GROUP_SIZE)

    def images_of_group(self, number: int) -> Ints:
        """Return the images of a group, ascending."""
        return np.arange(number * _GROUP_SIZE, min((number + 1) * _GROUP_SIZE, self.images))

    def read_group(self, number: int) -> Observations:
        """Return the observations of the images of a group, in their order."""
        return Observations(*self.store.get('seen', number))

    def read_images(self, wanted: Ints) -> Observations:
        """Return the observations of images, whose indices are ascending, shape (k,), in that order."""
        found = [_EMPTY]
        for number in np.unique(wanted // _GROUP_SIZE).tolist():
            observations = self.read_group(number)
            found.append(observations.where(np.isin(observations.image, wanted)))
        return Observations(*map(np.concatenate, zip(*(each.arrays for each in found), strict=True)))


def store_observations(
    images: Sequence[SurveyImage], chosen: Ints, dot_sigma: float, store: ArrayStore
) -> StoredObservations:
    """Store the observations of the chosen images, those on the map; ``dot_sigma`` as for `collect_observations`."""
    stored = StoredObservations(store, len(chosen))
    for number in range(stored.group_count):
        numbers = stored.images_of_group(number)
        group = [images[index] for index in chosen[numbers].tolist()]
        store.put('seen', number, *collect_observations(group, numbers, dot_sigma).arrays)
    return stored
