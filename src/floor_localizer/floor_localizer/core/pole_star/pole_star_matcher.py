"""The paper's pipeline (Fukase and Kanamori, 2.2 and 2.3) from one image's dots to a pose on the floor."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.arrays import Booleans, Floats, Ints
from floor_localizer.core.pole_star.signature import (
    SignatureTable,
    build_signature_table,
    pearson_residuals,
    top_candidates,
    vote,
)
from floor_localizer.core.settings import PoleStarSettings
from shirube_core.geometry import SE2


@njit(cache=True)
def mutual_distances(points: Floats, image_dots: NDArray[np.intp]) -> Floats:
    """Return the matrix of mutual distances, ``C_d`` of fig. 16 or ``F_d`` of fig. 17, shape (m, m) [m].

    ``points`` are the image dot or the candidate of each pair (image dot, candidate), shape (m, 2) [m]. The distance is
    NaN (NA in the paper) between pairs of the same image dot.
    """
    distances = np.full((len(points), len(points)), np.nan)
    for i in range(len(points)):
        for j in range(i):
            if image_dots[i] != image_dots[j]:
                x, y = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]
                distances[i, j] = distances[j, i] = math.sqrt(x * x + y * y)
    return distances


@njit(cache=True)
def agreement_matrix(C_d: Floats, F_d: Floats, tolerance: float) -> Booleans:
    """Return the 0/1 matrix of fig. 18: true where both distances agree within the tolerance [m], false for NA."""
    return np.abs(C_d - F_d) <= tolerance


@njit(cache=True)
def prune_to_congruent(agreement: Booleans) -> NDArray[np.intp]:
    """Remove the pair with the lowest column sum until every sum is one less than the remaining number (fig. 19).

    The paper does not specify which of several lowest columns is removed; here it is the first. The agreement matrix is
    symmetric and false on the diagonal; returned are the ascending indices of the pairs that all agree with each other.
    """
    sums = agreement.sum(axis=0)
    remaining = np.arange(len(agreement))
    while len(remaining) > 0:
        lowest = np.argmin(sums[remaining])
        if sums[remaining[lowest]] == len(remaining) - 1:
            break
        sums -= agreement[remaining[lowest]]
        remaining = np.delete(remaining, lowest)
    return remaining


def fit_pose(image_points: Floats, map_points: Floats) -> SE2:
    """Return the least-squares pose ``T_map_view`` of two or more paired dots, shape (n, 2) [m], no reflection."""
    image_centre, map_centre = image_points.mean(axis=0), map_points.mean(axis=0)
    a, b = (image_points - image_centre).T, (map_points - map_centre).T
    yaw = math.atan2(float(a[0] @ b[1] - a[1] @ b[0]), float(a[0] @ b[0] + a[1] @ b[1]))
    turn = SE2(0.0, 0.0, yaw)
    shift = map_centre - turn.transform(image_centre)
    return SE2(float(shift[0]), float(shift[1]), yaw)


def farthest_distances(image_points: Floats) -> Floats:
    """Return each image dot's distance to the image dot farthest from it, ``R_i`` of fig. 9, shape (n,) [m]."""
    return np.linalg.norm(image_points[:, None] - image_points[None, :], axis=2).max(axis=1)


def nodes_in_squares(centres: Floats, radii: Floats, pitch: float) -> tuple[NDArray[np.intp], Ints]:
    """Return which squares, of half sides ``radii`` [m], cover which grid nodes: indices of both, shape (e,) each."""
    low = np.ceil((centres - radii[:, None]) / pitch).astype(np.int64)
    high = np.floor((centres + radii[:, None]) / pitch).astype(np.int64)
    squares, nodes = [], []
    origin = low.min(axis=0)
    columns = int(high[:, 0].max() - origin[0]) + 1
    for step_x, step_y in np.ndindex(*np.maximum((high - low).max(axis=0), 0) + 1):
        column, row = (low + np.array([step_x, step_y])).T
        covering = np.flatnonzero((column <= high[:, 0]) & (row <= high[:, 1]))
        squares.append(covering)
        nodes.append((row[covering] - origin[1]) * columns + column[covering] - origin[0])
    return np.concatenate(squares), np.concatenate(nodes)


def candidate_regions(
    image_dots: NDArray[np.intp], candidate_points: Floats, radii: Floats, pitch: float, overlap_min: int
) -> list[NDArray[np.intp]]:
    """Return the regions where the squares of enough different image dots overlap (figs 12 and 13): indices of pairs.

    ``image_dots``, ``candidate_points`` [m] and ``radii``, ``R_i`` [m], are those of each pair (image dot, candidate);
    the overlap is counted at nodes ``pitch`` apart [m].
    """
    squares, nodes = nodes_in_squares(candidate_points, radii, pitch)
    order = np.lexsort((squares, nodes))
    next_node = np.flatnonzero(np.diff(nodes[order])) + 1
    regions = np.split(squares[order], next_node)
    return [pairs for pairs in regions if len(np.unique(image_dots[pairs])) >= overlap_min]


@dataclass(frozen=True)
class AddressMatrix:
    """The floor divided into square blocks; a block is occupied if it contains a dot.

    Attributes:
        occupied: shape (rows, columns), row along y, column along x.
        origin: shape (2,), lower left corner of block (0, 0) in the map frame [m].
        block: side of a block [m].
    """

    occupied: Booleans
    origin: Floats
    block: float


def build_address_matrix(map_points: Floats, block: float) -> AddressMatrix:
    """Return the address matrix of a floor; the paper takes blocks of 2.8 mm for dots of 2 to 3 mm (3.3.5)."""
    origin = map_points.min(axis=0)
    columns, rows = ((map_points - origin) / block).astype(np.intp).T
    occupied = np.zeros((rows.max() + 1, columns.max() + 1), dtype=np.bool_)
    occupied[rows, columns] = True
    return AddressMatrix(occupied, origin, block)


def match_rate(address_matrix: AddressMatrix, points: Floats) -> float:
    """Return the fraction of dots, transformed to the map frame, shape (n, 2) [m], that are in an occupied block.

    Dots off the floor do not match, and the rate of no dots is 0.
    """
    if len(points) == 0:
        return 0.0
    columns, rows = np.floor((points - address_matrix.origin) / address_matrix.block).astype(np.intp).T
    height, width = address_matrix.occupied.shape
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    return float(address_matrix.occupied[rows[inside], columns[inside]].sum() / len(points))


@dataclass(frozen=True)
class PoleStarPose:
    """A pose at which image dots and floor dots are congruent.

    Attributes:
        T_map_view: pose of the image's frame in the map frame.
        match_rate: fraction of the image's dots in an occupied block, in [0, 1].
        pairs: shape (k, 2), indices of the congruent image dots and floor dots.
    """

    T_map_view: SE2
    match_rate: float
    pairs: NDArray[np.intp]


@dataclass(frozen=True)
class NoPose:
    """No pose, and the reason in one line."""

    reason: str


class PoleStarMatcher:
    """Finds an image's dots among the dots of a floor, without a prior."""

    def __init__(self, map_points: Floats, settings: PoleStarSettings) -> None:
        """Build the databases of a floor: its dots in the map frame, shape (N, 2), at least two [m]."""
        self._map_points = map_points
        self._settings = settings
        self._table: SignatureTable = build_signature_table(map_points, settings.radius, settings.quantum)
        self._address_matrix: AddressMatrix = build_address_matrix(map_points, settings.address_block)

    def match(self, image_points: Floats) -> PoleStarPose | NoPose:
        """Return the pose with the best match rate, or the reason for no pose (2.3.3), of all dots of an image
        in the view's frame, shape (n, 2) [m].
        """
        minimum = self._settings.congruent_min
        if len(image_points) < minimum:
            return NoPose(f'{len(image_points)} dots, a pose needs {minimum}')
        return self.select_pose(self.congruent_poses(image_points))

    def select_pose(self, poses: list[PoleStarPose]) -> PoleStarPose | NoPose:
        """Return the first of `congruent_poses` if its match rate is high enough (reference match rate of 3.3.5)."""
        minimum = self._settings.match_rate_min
        if not poses:
            return NoPose(f'no region has {self._settings.congruent_min} congruent dots')
        if poses[0].match_rate < minimum:
            return NoPose(f'best match rate {poses[0].match_rate:.3f} is below {minimum:.3f}')
        return poses[0]

    def congruent_poses(self, image_points: Floats) -> list[PoleStarPose]:
        """Return a pose for each region with congruent dots, the highest match rate first; at least two dots,
        as in `match`.
        """
        settings = self._settings
        radii = farthest_distances(image_points)

        # 2.2: candidates of each image dot by the votes of its distances.
        votes = vote(self._table, image_points, settings.vote_tolerance)
        candidates = top_candidates(pearson_residuals(votes), self._candidates_per_dot(radii))
        image_dots = np.repeat(np.arange(len(image_points)), candidates.shape[1])
        map_dots = candidates.ravel()

        # 2.3.1: regions where the squares around the candidates overlap.
        regions = candidate_regions(
            image_dots, self._map_points[map_dots], radii[image_dots], settings.grid_pitch, settings.overlap_min
        )

        # 2.3.2 and 2.3.3: the congruent pairs of each region, their pose and its match rate.
        poses = []
        for region in regions:
            pairs = self._congruent_pairs(image_points, image_dots[region], map_dots[region])
            if len(pairs) >= settings.congruent_min:
                poses.append(self._pose(image_points, pairs))
        return sorted(poses, key=lambda pose: pose.match_rate, reverse=True)

    def _candidates_per_dot(self, radii: Floats) -> int:
        """Return the number of candidates per image dot for which a region holds ``pairs_per_region`` by chance.

        The paper does not specify how many dots have "the most votes". A random candidate is in a region with a
        probability equal to its square's fraction of the floor area.
        """
        floor_area = float(np.prod(np.ptp(self._map_points, axis=0)))
        squares_area = float(np.sum((2.0 * radii) ** 2))
        if squares_area == 0.0:
            return 1
        return max(1, round(self._settings.pairs_per_region * floor_area / squares_area))

    def _congruent_pairs(
        self, image_points: Floats, image_dots: NDArray[np.intp], map_dots: NDArray[np.intp]
    ) -> NDArray[np.intp]:
        """Return the congruent pairs of a region, shape (k, 2): image dot, floor dot."""
        C_d = mutual_distances(image_points[image_dots], image_dots)
        F_d = mutual_distances(self._map_points[map_dots], image_dots)
        congruent = prune_to_congruent(agreement_matrix(C_d, F_d, self._settings.congruence_tolerance))
        return np.column_stack([image_dots[congruent], map_dots[congruent]])

    def _pose(self, image_points: Floats, pairs: NDArray[np.intp]) -> PoleStarPose:
        T_map_view = fit_pose(image_points[pairs[:, 0]], self._map_points[pairs[:, 1]])
        rate = match_rate(self._address_matrix, T_map_view.transform(image_points))
        return PoleStarPose(T_map_view, rate, pairs)
