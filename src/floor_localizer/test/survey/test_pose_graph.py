"""The pose graph: all submaps at once, and each as it comes."""

import numpy as np

from floor_localizer.core.survey.submap_graph import pose_graph
from floor_localizer.core.survey.submap_graph.pose_graph import (
    PoseGraphEdge,
    SubmapPoses,
    component_labels,
    optimize_pose_graph,
)

LANE = 20
DRIFT = 0.0005
"""Yaw error of each submap relative to the previous one [rad]."""


def edge_between(first, second, rotations, translations, rng, drift=DRIFT) -> PoseGraphEdge:
    """Edge of nine dots that two submaps with true similarities share."""
    middle = 0.5 * (translations[first] + translations[second])
    shared = middle + rng.uniform(-0.1, 0.1, 9) + 1j * rng.uniform(-0.1, 0.1, 9)
    points = [(shared - translations[k]) / rotations[k] for k in (first, second)]
    bent = np.exp(1j * rng.normal(0.0, drift))
    return PoseGraphEdge(first, second, points[0], bent * points[1], abs(first - second) != 1)


def random_rotations(count: int, rng: np.random.Generator) -> np.ndarray:
    rotations = np.exp(1j * rng.uniform(-3.0, 3.0, count))
    rotations[0] = 1.0
    return rotations


def ring(count: int, radius: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Similarities of submaps around a ring, the first of which is the identity."""
    return random_rotations(count, rng), radius * (np.exp(2j * np.pi * np.arange(count) / count) - 1.0)


def lanes(count: int) -> tuple[np.ndarray, np.ndarray, list[list[PoseGraphEdge]]]:
    """Submaps in lanes over a floor, their true similarities, and edges to the previous and the neighbouring one."""
    rng = np.random.default_rng(3)
    row, along = np.divmod(np.arange(count), LANE)
    translations = 0.5 * np.where(row % 2 == 0, along, LANE - 1 - along) + 0.1j * row
    rotations = random_rotations(count, rng)
    edges: list[list[PoseGraphEdge]] = []
    for k in range(count):
        neighbour = 2 * LANE * (k // LANE) - 1 - k
        others = [k - 1] * (k > 0) + [neighbour] * (0 <= neighbour < k - 1)
        edges.append([edge_between(other, k, rotations, translations, rng) for other in others])
    return rotations, translations, edges


def build_poses(edges: list[list[PoseGraphEdge]]) -> SubmapPoses:
    poses = SubmapPoses()
    for new in edges:
        poses.append(1.0 + 0.0j, 0.0j)
        poses.add_edges(new)
    return poses


def test_the_true_poses_are_found_without_an_initial_guess():
    rng, numbers = np.random.default_rng(3), np.arange(12)
    rotations, translations = ring(12, 1.0, rng)
    rotations[1:] *= 1.0 + rng.normal(0.0, 0.0001, 11)
    edges = [edge_between(k, (k + 1) % 12, rotations, translations, rng, drift=0.0) for k in range(12)]
    start = rotations / np.abs(rotations)
    found = optimize_pose_graph(start, np.zeros(12, complex), numbers, edges, numbers > 0, 0.0001)
    np.testing.assert_allclose(found, [rotations, translations], atol=0.0005)


def test_components_without_an_edge_have_different_labels():
    rng = np.random.default_rng(3)
    similarities = ring(12, 1.0, rng)
    edges = [edge_between(k, (k + 1) % 12, *similarities, rng) for k in range(12) if k not in (3, 8)]
    parts = component_labels(13, edges)
    assert len(set(parts)) == 3
    assert parts[4] == parts[8] != parts[9]
    assert list(parts).count(parts[12]) == 1


def test_submap_poses_are_right_after_each_edge():
    *similarities, edges = lanes(200)
    assert np.abs(np.subtract(build_poses(edges).arrays(), similarities)).max() < 0.01


def test_the_work_is_linear_in_the_number_of_submaps(monkeypatch):
    sizes: list[int] = []

    def counted(rotations: np.ndarray, *arguments: object) -> tuple[np.ndarray, np.ndarray]:
        sizes.append(len(rotations))
        return optimize_pose_graph(rotations, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(pose_graph, 'optimize_pose_graph', counted)
    work = []
    for count in (200, 800):
        sizes.clear()
        build_poses(lanes(count)[2])
        work.append(sum(sizes))
    assert work[1] < 6 * work[0]


def test_a_loop_closure_with_large_drift_corrects_the_whole_loop():
    """A ring whose drift shows only when it closes, more submaps later than the sliding window."""
    count, rng = 150, np.random.default_rng(5)
    similarities = ring(count, 10.0, rng)
    edges = [[edge_between(k - 1, k, *similarities, rng)] if k else [] for k in range(count)]
    before = build_poses(edges)
    closing = edge_between(0, count - 1, *similarities, rng)
    edges[-1].append(closing)
    after = build_poses(edges)
    assert gap(before, closing) > 0.02
    assert gap(after, closing) < 0.002
    # All of the ring has moved, not only the last submaps.
    assert np.abs(after.arrays()[1] - before.arrays()[1])[10:40].min() > 0.0005


def gap(poses: SubmapPoses, edge: PoseGraphEdge) -> float:
    rotations, translations = poses.arrays()
    first = rotations[edge.first] * edge.points_first + translations[edge.first]
    second = rotations[edge.second] * edge.points_second + translations[edge.second]
    return float(np.abs(first - second).max())
