"""Incremental optimisation of the pose graph while submaps are added.

A new submap is aligned to its edges. If a small residual is left, a sliding window of the last submaps is optimised.
The whole graph is optimised if that is not enough, if the residual of a loop closure is large, and whenever the number
of submaps has grown by a fraction, so that the total work is linear in their number.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.pose_graph import PoseGraphEdge, optimize_pose_graph

DOT_SIGMA = 0.0002
"""Standard deviation of a dot in a submap, which may be slightly bent [m]."""
_SMALL_RESIDUAL, _LARGE_RESIDUAL = 0.001, 0.005
"""Residual of an edge above which the window, and above which the whole graph is optimised [m]."""
_OPTIMIZE_EVERY, _OPTIMIZE_FRACTION = 8, 0.1
_WINDOW = 64
"""Number of submaps in the sliding window."""


class SubmapPoses:
    """Similarities a z + b of the submaps in the map frame.

    Attributes:
        rotations: complex rotation and scale a of each submap.
        translations: complex translation b of each submap [m].
        edges: edges between the submaps.
    """

    def __init__(self) -> None:
        """Begin without a submap."""
        self.rotations: list[complex] = []
        self.translations: list[complex] = []
        self.edges: list[PoseGraphEdge] = []
        self._edges_of: list[list[PoseGraphEdge]] = []
        self._added_since_optimized = 0

    def append(self, rotation: complex, translation: complex) -> None:
        """Add a submap."""
        self.rotations.append(rotation)
        self.translations.append(translation)
        self._edges_of.append([])

    def add_edges(self, edges: Sequence[PoseGraphEdge]) -> None:
        """Add edges of the last submap, align it to them, and optimise the graph if a residual is left."""
        if not edges:
            return
        subsampled = [edge.subsample() for edge in edges]
        self.edges += subsampled
        self._edges_of[-1] += subsampled
        self._added_since_optimized += 1
        count = len(self.rotations)
        residual = self.align(edges)
        if _SMALL_RESIDUAL < residual < _LARGE_RESIDUAL:
            self._optimize_from(max(count - _WINDOW, 1))
            residual = self._max_residual(edges)
        if residual > _SMALL_RESIDUAL or self._added_since_optimized >= max(
            _OPTIMIZE_EVERY, _OPTIMIZE_FRACTION * count
        ):
            self.optimize()

    def align(self, edges: Sequence[PoseGraphEdge]) -> float:
        """Align the second submap of some edges to them; return the largest remaining residual [m]."""
        own_points = np.concatenate([edge.points_second for edge in edges])
        other_points = np.concatenate(
            [self.rotations[edge.first] * edge.points_first + self.translations[edge.first] for edge in edges]
        )
        centred = own_points - own_points.mean()
        rotation = np.vdot(centred, other_points - other_points.mean())
        rotation /= abs(rotation)
        index, translation = edges[0].second, other_points.mean() - rotation * own_points.mean()
        self.rotations[index], self.translations[index] = complex(rotation), complex(translation)
        return self._max_residual(edges)

    def optimize(self) -> None:
        """Optimise all submaps but the first."""
        self._added_since_optimized = 0
        self._optimize_from(1)

    def arrays(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Return the similarities, shape (n,) each."""
        return np.array(self.rotations), np.array(self.translations)

    def _optimize_from(self, begin: int) -> None:
        """Optimise the submaps from one on; the others are fixed."""
        edges = [edge for submap_edges in self._edges_of[begin:] for edge in submap_edges]
        if not edges:
            return
        submaps = np.unique([(edge.first, edge.second) for edge in edges])
        rotations, translations = (np.array(each)[submaps] for each in (self.rotations, self.translations))
        rotations, translations = optimize_pose_graph(
            rotations, translations, submaps, edges, submaps >= begin, DOT_SIGMA
        )
        for submap, rotation, translation in zip(
            submaps.tolist(), rotations.tolist(), translations.tolist(), strict=True
        ):
            self.rotations[submap], self.translations[submap] = rotation, translation

    def _max_residual(self, edges: Sequence[PoseGraphEdge]) -> float:
        return max(
            float(np.abs(
                self.rotations[edge.first] * edge.points_first + self.translations[edge.first]
                - self.rotations[edge.second] * edge.points_second - self.translations[edge.second]
            ).max())
            for edge in edges
        )  # fmt: skip
