import numpy as np

from floor_localizer.core.survey.submap_graph import pose_graph
from floor_localizer.core.survey.submap_graph.pose_graph import (
    PoseGraphEdge,
    SubmapPoses,
    optimize_pose_graph,
)

LANE = 20
DRIFT = 0.0005
"""Yaw error of each submap relative to the previous one [rad]."""


def lanes(count: int, seed: int = 3) -> tuple[np.ndarray, np.ndarray, list[list[PoseGraphEdge]]]:
    """Submaps in lanes over a floor, their true similarities, and edges to the previous and the neighbouring one."""
    rng = np.random.default_rng(seed)
    row, along = np.divmod(np.arange(count), LANE)
    translations = 0.5 * np.where(row % 2 == 0, along, LANE - 1 - along) + 0.1j * row
    rotations = np.exp(1j * rng.uniform(-3.0, 3.0, count))
    rotations[0] = 1.0
    edges: list[list[PoseGraphEdge]] = []
    for k in range(count):
        neighbour = 2 * LANE * (k // LANE) - 1 - k
        others = [k - 1] * (k > 0) + [neighbour] * (0 <= neighbour < k - 1)
        edges.append([edge_between(k, other, rotations, translations, rng) for other in others])
    return rotations, translations, edges


def edge_between(
    k: int, other: int, rotations: np.ndarray, translations: np.ndarray, rng: np.random.Generator
) -> PoseGraphEdge:
    shared = (
        0.5 * (translations[k] + translations[other])
        + rng.uniform(-0.1, 0.1, 9)
        + 1j * rng.uniform(-0.1, 0.1, 9)
    )
    points_first, points_second = ((shared - translations[j]) / rotations[j] for j in (other, k))
    bent = np.exp(1j * rng.normal(0.0, DRIFT))
    return PoseGraphEdge(other, k, points_first, bent * points_second, other != k - 1)


def build_poses(edges: list[list[PoseGraphEdge]]) -> SubmapPoses:
    poses = SubmapPoses()
    for new in edges:
        poses.append(1.0 + 0.0j, 0.0j)
        poses.add_edges(new)
    return poses


def test_submap_poses_are_right_after_each_edge():
    rotations, translations, edges = lanes(200)
    found_rotations, found_translations = build_poses(edges).arrays()
    assert np.abs(found_translations - translations).max() < 0.01
    assert np.abs(found_rotations - rotations).max() < 0.01


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
    rotations = np.exp(1j * rng.uniform(-3.0, 3.0, count))
    rotations[0] = 1.0
    translations = 10.0 * np.exp(2j * np.pi * np.arange(count) / count) - 10.0
    edges = [[edge_between(k, k - 1, rotations, translations, rng)] if k else [] for k in range(count)]
    before = build_poses(edges)
    closing = edge_between(count - 1, 0, rotations, translations, rng)
    edges[-1].append(closing)
    after = build_poses(edges)
    assert gap(before, closing) > 0.02
    assert gap(after, closing) < 0.002
    # All of the ring has moved, not only the last submaps.
    assert np.abs(after.arrays()[1] - before.arrays()[1])[10:40].min() > 0.0005


def gap(poses: SubmapPoses, edge: PoseGraphEdge) -> float:
    rotations, translations = poses.arrays()
    ends = (
        rotations[edge.first] * edge.points_first + translations[edge.first],
        rotations[edge.second] * edge.points_second + translations[edge.second],
    )
    return float(np.abs(ends[0] - ends[1]).max())
