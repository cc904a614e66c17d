import numpy as np

from floor_localizer.core.survey.submap_graph.pose_graph import (
    PoseGraphEdge,
    component_labels,
    optimize_pose_graph,
)


def ring(count: int = 12) -> tuple[np.ndarray, np.ndarray, list[PoseGraphEdge]]:
    """Submaps around a ring with true similarities, each with an edge of shared dots to the next one."""
    rng = np.random.default_rng(3)
    rotations = np.exp(1j * rng.uniform(-3.0, 3.0, count)) * (1.0 + rng.normal(0.0, 0.0001, count))
    translations = np.exp(1j * 2 * np.pi * np.arange(count) / count)
    rotations[0], edges = 1.0, []
    for k in range(count):
        other = (k + 1) % count
        shared = (
            0.5 * (translations[k] + translations[other])
            + rng.uniform(-0.1, 0.1, 9)
            + 1j * rng.uniform(-0.1, 0.1, 9)
        )
        first, second = ((shared - translations[j]) / rotations[j] for j in (k, other))
        edges.append(PoseGraphEdge(k, other, first, second, other == 0))
    return rotations, translations, edges


def test_the_true_poses_are_found_without_an_initial_guess():
    rotations, translations, edges = ring()
    start = rotations / np.abs(rotations)
    found_rotations, found_translations = optimize_pose_graph(
        start,
        np.where(np.arange(12) == 0, translations, 0.0),
        np.arange(12),
        edges,
        np.arange(12) > 0,
        0.0001,
    )
    np.testing.assert_allclose(found_translations, translations, atol=0.0005)
    np.testing.assert_allclose(found_rotations, rotations, atol=0.0005)


def test_components_without_an_edge_have_different_labels():
    edges = ring()[2]
    parts = component_labels(13, [edge for edge in edges if edge.first not in (3, 8)])
    assert len(set(parts)) == 3
    assert parts[4] == parts[8] != parts[9]
    assert list(parts).count(parts[12]) == 1
