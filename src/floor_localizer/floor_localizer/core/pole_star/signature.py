"""Pole-star signatures: the distances from one dot to its neighbours (paper 2.2).

The text of 2.2 ends after the principle (2.2.1): the distances from a dot to all dots within the pole-star
radius are specific to that dot and invariant to rotation. The rest is our design:

- The database is a table distance → dots: ``counts[k, j]`` is the number of neighbours of floor dot ``j`` at
  the quantised distance ``k``.
- Each dot of the image in turn is the pole. Each of its distances votes, within a tolerance, for the floor
  dots with that distance in the table. A distance has one vote, divided among these dots: twice as many dots have
  a neighbour 40 mm away as 20 mm away, so the longer distance is half as informative.
- A floor dot in a dense area gets votes from every pole, right or wrong. So votes are compared with the average over
  all poles; otherwise most candidates would be in dense areas.
- The dots with the most votes above that average are the pole's candidates.

A missing neighbour costs nothing; the vote of a spurious one is distributed over the whole floor.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from floor_localizer.core.arrays import Float32s, Floats


@dataclass(frozen=True)
class SignatureTable:
    """The signatures of all dots of a floor, by distance.

    Attributes:
        counts: shape (K, N), number of neighbours of dot j at a distance in [k, k + 1) quanta.
        quantum: quantization step of distances [m].
        radius: the pole-star radius [m].
    """

    counts: Float32s
    quantum: float
    radius: float


def pole_star_signature(points: Floats, pole: int, radius: float) -> Floats:
    """Return the signature of one dot: the ascending distances to its neighbours within the radius, shape (k,) [m]."""
    neighbours = np.delete(points, pole, axis=0)
    distances = np.linalg.norm(neighbours - points[pole], axis=1)
    return np.sort(distances[distances < radius])


def build_signature_table(map_points: Floats, radius: float, quantum: float) -> SignatureTable:
    """Return the table distance → dots of a floor; ``quantum`` is the quantization step of distances [m]."""
    size = int(np.ceil(radius / quantum))
    counts = np.zeros((size, len(map_points)), dtype=np.float32)
    pairs = KDTree(map_points).query_pairs(radius, output_type='ndarray')
    distances = np.linalg.norm(map_points[pairs[:, 0]] - map_points[pairs[:, 1]], axis=1)
    quantised = np.minimum((distances / quantum).astype(np.intp), size - 1)
    for pole in pairs.T:
        np.add.at(counts, (quantised, pole), np.float32(1.0))
    return SignatureTable(counts, quantum, radius)


def vote(table: SignatureTable, image_points: Floats, tolerance: float) -> Float32s:
    """Let each image dot's distances vote for floor dots with the same distance [m]: votes, shape (n, N)."""
    quanta = (np.arange(len(table.counts)) + 0.5) * table.quantum
    entries = table.counts.sum(axis=1)
    vote_weights = np.zeros((len(image_points), len(quanta)), dtype=np.float32)
    for pole in range(len(image_points)):
        signature = pole_star_signature(image_points, pole, table.radius)
        agrees = np.abs(quanta - signature[:, None]) <= tolerance
        weights = 1.0 / np.maximum(agrees @ entries, 1.0)
        vote_weights[pole] = weights @ agrees
    return vote_weights @ table.counts


def pearson_residuals(votes: Float32s) -> Float32s:
    """Return the Pearson residuals of votes, shape (n, N): the votes above average, over their standard deviation.

    The average vote of dot i for dot j is (all votes of i) x (all votes for j) / (all votes), and the standard
    deviation of a sum of many small votes is about its square root.
    """
    tiny = np.finfo(np.float32).tiny
    by_image_dot, by_floor_dot = votes.sum(axis=1), votes.sum(axis=0)
    average = np.outer(by_image_dot / np.maximum(by_image_dot.sum(), tiny), by_floor_dot).astype(np.float32)
    return np.divide(votes - average, np.sqrt(np.maximum(average, tiny)), dtype=np.float32)


def top_candidates(votes: Float32s, count: int) -> NDArray[np.intp]:
    """Return each image dot's candidates, the floor dots with most votes, shape (n, min(count, N)), unordered."""
    if count >= votes.shape[1]:
        return np.tile(np.arange(votes.shape[1]), (len(votes), 1))
    return np.argpartition(votes, -count, axis=1)[:, -count:]
