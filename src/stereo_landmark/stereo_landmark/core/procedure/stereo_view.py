"""The primitives of an image and of a stereo pair, and their corresponding points (paper 3.3d)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from stereo_landmark.core.arrays import Floats, GreyImage, Ints, Masks
from stereo_landmark.core.edges.edges import Segments, extract_edges, trace_segments
from stereo_landmark.core.primitives.corner import detect_corners
from stereo_landmark.core.primitives.ellipse import detect_ellipses
from stereo_landmark.core.primitives.line_segments import fit_line_segments
from stereo_landmark.core.primitives.parallel_lines import detect_parallel_lines
from stereo_landmark.core.primitives.primitive import (
    ImageProcessing,
    Primitive,
    PrimitiveKind,
    align_point_order,
    invariant_points,
    refine,
    shape_descriptors,
    shape_vectors,
)
from stereo_landmark.core.primitives.quadrilateral import detect_quadrilaterals
from stereo_landmark.core.primitives.shape import LazyShapes
from stereo_landmark.core.procedure.stereo_matching import candidate_pairs, is_contested, mutual_best, neighbour_support
from stereo_landmark.core.stereo import MEASUREMENT_SIZE, CameraView, StereoPoints, StereoRig


@dataclass(frozen=True)
class DetectedPrimitives:
    """All primitives of one kind in an image.

    Attributes:
        kind: kind of all the primitives.
        primitives: n primitives.
    """

    kind: PrimitiveKind
    primitives: Sequence[Primitive]

    @cached_property
    def centres(self) -> Floats:
        """Centres of the primitives, shape (n, 2) [px]."""
        if isinstance(self.primitives, LazyShapes):
            return self.primitives.centres
        return np.array([each.centre for each in self.primitives]).reshape(-1, 2)

    @cached_property
    def shape_vectors(self) -> Floats:
        """Shape vectors of the primitives, shape (n, d), see `shape_vectors`."""
        return shape_vectors(self.kind, self.primitives)

    @cached_property
    def descriptors(self) -> Floats:
        """Shape descriptors of the primitives, shape (n, DESCRIPTOR_SIZE)."""
        return shape_descriptors(self.kind, self.shape_vectors)

    @cached_property
    def kd_tree(self) -> cKDTree:
        """KD-tree of the centres, for radius searches."""
        return cKDTree(self.centres)


@dataclass(frozen=True)
class DetectedScene:
    """Segments and primitives detected in one image.

    Attributes:
        image: grey image, shape (h, w).
        segments: edge segments.
        kinds: detected primitives by kind.
    """

    image: GreyImage
    segments: Segments
    kinds: dict[PrimitiveKind, DetectedPrimitives]


def detect_scene(
    image: GreyImage,
    processing: ImageProcessing,
    kinds: Iterable[PrimitiveKind] = tuple(PrimitiveKind),
    region: Masks | None = None,
) -> DetectedScene:
    """Detect the primitives of an image.

    Args:
        image: grey image, shape (h, w).
        processing: taught image processing.
        kinds: kinds of primitives to detect.
        region: mask of the pixels to consider, shape (h, w); None for all.

    Raises:
        StereoLandmarkError: the image has the wrong type or shape, or is too small.
    """
    wanted = set(kinds)
    segments = trace_segments(extract_edges(image, processing.edges, region), processing.edges)
    found: dict[PrimitiveKind, DetectedPrimitives] = {}
    if PrimitiveKind.ELLIPSE in wanted:
        found[PrimitiveKind.ELLIPSE] = DetectedPrimitives(
            PrimitiveKind.ELLIPSE, tuple(detect_ellipses(segments, processing.primitives))
        )
    if wanted - {PrimitiveKind.ELLIPSE}:
        sides = fit_line_segments(segments, processing.primitives)
        for kind, detect in (
            (PrimitiveKind.QUADRILATERAL, detect_quadrilaterals),
            (PrimitiveKind.PARALLEL_LINES, detect_parallel_lines),
            (PrimitiveKind.CORNER, detect_corners),
        ):
            if kind in wanted:
                found[kind] = DetectedPrimitives(kind, detect(sides, processing.primitives))
    return DetectedScene(image, segments, found)


DEPTH_RANGE = (0.3, 30.0)
"""Minimum and maximum depth of a landmark [m]."""

SUPPORT_WEIGHTS = {
    PrimitiveKind.ELLIPSE: 1.0,
    PrimitiveKind.QUADRILATERAL: 1.0,
    PrimitiveKind.PARALLEL_LINES: 0.5,
    PrimitiveKind.CORNER: 0.2,
}
"""Support weight of a primitive for its neighbours: many corners are visible in one camera only."""


@dataclass(frozen=True)
class StereoView(CameraView):
    """Detected primitives of both images.

    Attributes:
        left: primitives of the left image.
        right: primitives of the right image, of the same kinds.
        rig: stereo cameras.
        tilt: roll and pitch of the base [rad].
    """

    left: DetectedScene
    right: DetectedScene
    rig: StereoRig
    tilt: tuple[float, float] = (0.0, 0.0)

    def detected_pair(self, kind: PrimitiveKind) -> tuple[DetectedPrimitives, DetectedPrimitives]:
        """Return the primitives of a kind in the left and in the right image."""
        return self.left.kinds[kind], self.right.kinds[kind]

    def match_indices(self, kind: PrimitiveKind) -> Ints:
        """Return the index of the right primitive matched to each left one, shape (n,); -1 without a match."""
        if kind not in self._matches:
            # Primitives of all kinds support each other, but only those of this kind are matched now.
            indices = match_pairs(
                [self.left.kinds[each].centres for each in self._candidates],
                list(self._candidates.values()),
                [self._disparities(each, pairs) for each, pairs in self._candidates.items()],
                [SUPPORT_WEIGHTS[each] for each in self._candidates],
                list(self._candidates).index(kind),
            )
            self._matches[kind] = np.full(len(self.left.kinds[kind].primitives), -1)
            self._matches[kind][indices[:, 0]] = indices[:, 1]
        return self._matches[kind]

    @cached_property
    def _matches(self) -> dict[PrimitiveKind, Ints]:
        """Cached matches by kind."""
        return {}

    @cached_property
    def _candidates(self) -> dict[PrimitiveKind, Ints]:
        """Candidate pairs by kind, each of shape (m, 2)."""
        return {kind: self._candidate_pairs(kind) for kind in self.left.kinds}

    def _candidate_pairs(self, kind: PrimitiveKind) -> Ints:
        here, there = self.detected_pair(kind)
        scale = self.rig.left.fx * self.rig.baseline
        return candidate_pairs(
            here.centres - [self.rig.left.cx, 0.0],
            here.descriptors,
            there.centres - [self.rig.right.cx, 0.0],
            there.descriptors,
            (scale / DEPTH_RANGE[1], scale / DEPTH_RANGE[0]),
        )

    def _disparities(self, kind: PrimitiveKind, indices: Ints) -> Floats:
        here, there = self.detected_pair(kind)
        pixels = np.hstack([here.centres[indices[:, 0]], there.centres[indices[:, 1]]])
        return self.rig.disparities(pixels)


def match_pairs(
    centres: Sequence[Floats],
    pairs: Sequence[Ints],
    disparities: Sequence[Floats],
    weights: Sequence[float],
    kind_index: int,
) -> Ints:
    """Return the matched pairs of one kind, shape (k, 2). Primitives of all kinds support each other.

    Args:
        centres: centres in the left image for each kind, shape (n, 2) [px].
        pairs: candidate pairs for each kind, shape (m, 2), see `candidate_pairs`.
        disparities: disparities of the pairs for each kind, shape (m,) [px].
        weights: support weight of a primitive of each kind.
        kind_index: index of the kind to match.
    """
    begin, end = np.cumsum([0, *(len(numbers) for numbers in pairs)])[kind_index : kind_index + 2]
    requested = np.zeros(sum(len(numbers) for numbers in pairs), dtype=np.bool_)
    requested[begin:end] = is_contested(pairs[kind_index], disparities[kind_index])
    first = np.cumsum([0, *(len(each) for each in centres)])
    support = neighbour_support(
        np.concatenate([each[numbers[:, 0]] for each, numbers in zip(centres, pairs, strict=True)]),
        np.concatenate(disparities),
        np.concatenate([numbers[:, 0] + offset for numbers, offset in zip(pairs, first, strict=False)]),
        np.repeat(weights, [len(numbers) for numbers in pairs]),
        requested,
    )
    return np.asarray(
        pairs[kind_index][mutual_best(pairs[kind_index], disparities[kind_index], support[begin:end])], dtype=np.int64
    )


NamedPair = tuple[str, Primitive, Primitive]
"""Name of a primitive, and its shape in the left and in the right image."""


def align_pair(taught: Primitive, left: Primitive, right: Primitive) -> tuple[Primitive, Primitive]:
    """Reorder the points of both shapes to correspond to those of the taught one."""
    ordered = align_point_order(left, taught)
    return ordered, align_point_order(right, ordered)


def refine_pair(
    left: Primitive, right: Primitive, images: tuple[GreyImage, GreyImage]
) -> tuple[Primitive, Primitive] | None:
    """Refine a primitive in both grey images, shapes (h, w); None if it is not visible in one of them."""
    here, there = refine(left, images[0]), refine(right, images[1])
    return None if here is None or there is None else (here, there)


def stereo_points(pairs: Iterable[NamedPair]) -> StereoPoints:
    """Return the invariant points of primitives, which correspond in both images, named ``primitive/point``."""
    names: list[str] = []
    pixels: list[np.ndarray] = []
    covariances: list[np.ndarray] = []
    for name, left, right in pairs:
        here, there = left.image_points(), right.image_points()
        for point in invariant_points(left):
            names.append(f'{name}/{point}')
            pixels.append(np.concatenate([here[point].position, there[point].position]))
            covariance = np.zeros((MEASUREMENT_SIZE, MEASUREMENT_SIZE))
            covariance[:2, :2], covariance[2:, 2:] = here[point].covariance, there[point].covariance
            covariances.append(covariance)
    return StereoPoints(
        tuple(names),
        np.array(pixels).reshape(-1, MEASUREMENT_SIZE),
        np.array(covariances).reshape(-1, MEASUREMENT_SIZE, MEASUREMENT_SIZE),
    )
