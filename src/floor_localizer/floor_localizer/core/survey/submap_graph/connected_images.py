"""Build the pose graph of the submaps; return the connected images with their initial states."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from floor_localizer.core.arrays import Complexes, Floats, Ints
from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.array_store import ArrayStore, StepCheckpoint
from floor_localizer.core.survey.submap import Submap
from floor_localizer.core.survey.submap_graph.pose_graph import component_labels
from floor_localizer.core.survey.submap_graph.pose_graph_builder import PoseGraphBuilder
from floor_localizer.core.survey.survey_image import SurveyImage

_MIN_FRACTION = 0.5  # smallest fraction of the images that must be connected


@dataclass(frozen=True)
class ConnectedImages:
    """Images that are connected by the pose graph.

    Attributes:
        images: indices of the images, shape (k,).
        states: x, y [m], yaw [rad], scale, roll, pitch [rad] of each, shape (k, 6).
        loop_closures: number of loop closures.
    """

    images: Ints
    states: Floats
    loop_closures: int


def connect_images(
    images: Sequence[SurveyImage],
    submaps: Iterable[Submap],
    settings: SurveySettings,
    store: ArrayStore,
    existing: DotMap | None,
    checkpoint: StepCheckpoint,
) -> ConnectedImages:
    """Build and optimise the pose graph, unless the checkpoint has it; return the images of its main component.

    The submaps come in order, the store is for their dots, and an existing map is extended.

    Raises:
        FloorLocalizerError: the images do not overlap.
    """
    known = checkpoint.load_step('linked')
    if known is not None:
        return ConnectedImages(known['images'], known['states'], int(known['loop_closures']))
    builder = PoseGraphBuilder(images, settings, None if existing is None else existing.points, store)
    for submap in submaps:
        builder.add(submap)
    builder.poses.optimize()
    rotations, translations = builder.poses.arrays()
    chosen = _main_component(builder, 0 if existing is None else 1, images)
    used, states = _global_states([builder.submaps[k] for k in chosen], rotations[chosen], translations[chosen])
    loop_closures = sum(edge.is_loop_closure for edge in builder.poses.edges)
    checkpoint.save_step('linked', images=used, states=states, loop_closures=np.array(loop_closures))
    return ConnectedImages(used, states, loop_closures)


def _main_component(builder: PoseGraphBuilder, first: int, images: Sequence[SurveyImage]) -> Ints:
    """Return the submaps that are connected to the existing map, or those of the largest component."""
    submaps = builder.submaps
    labels = component_labels(len(submaps), builder.poses.edges)
    sizes = np.array([len(submap.images) for submap in submaps])
    main = labels[0] if first else int(np.argmax(np.bincount(labels, sizes)))
    chosen = first + np.flatnonzero(labels[first:] == main)
    fraction = sizes[chosen].sum() / sizes.sum()
    if len(chosen) == 0:
        raise FloorLocalizerError(
            'the images show nothing of the map that is to be extended; begin the drive on floor that is in it'
        )
    if fraction < _MIN_FRACTION:
        disconnected = next(submaps[k] for k in range(first + 1, len(submaps)) if labels[k] != labels[k - 1])
        raise FloorLocalizerError(
            f'no overlap: only {fraction:.0%} of the images are connected, '
            f'{images[disconnected.images[0]].name} matches none before it; drive slower or in narrower lanes, '
            'and check camera_xyz, camera_rpy and the odometry'
        )
    return chosen


def _global_states(submaps: Sequence[Submap], rotations: Complexes, translations: Complexes) -> tuple[Ints, Floats]:
    """Return the images of submaps, each once, and their states on the map."""
    used: dict[int, Floats] = {}
    for submap, a, b in zip(submaps, rotations, translations, strict=True):
        poses = a * (submap.states[:, :2] @ (1.0, 1j)) + b
        for index, place, state in zip(submap.images.tolist(), poses, submap.states, strict=True):
            transformed = state.copy()
            transformed[:3] = place.real, place.imag, state[2] + np.angle(a)
            transformed[3] = (1.0 + state[3]) * abs(a) - 1.0
            used.setdefault(index, transformed)
    order = np.array(sorted(used), dtype=np.int64)
    return order, np.array([used[index] for index in order.tolist()])
