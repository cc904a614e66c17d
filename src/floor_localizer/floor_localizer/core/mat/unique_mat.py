"""A mat of which every view is unlike every other, checked with the search that the robot will use."""

from __future__ import annotations

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.mat.mat_settings import MatSettings
from floor_localizer.core.mat.random_mat import Mat, lay_mat
from floor_localizer.core.settings import LocalizerSettings
from floor_localizer.core.uniqueness import Place, PlaceKind, ViewSettings, inspect_places, list_places

_TRIALS = 5


def lay_unique_mat(settings: MatSettings, seed: int, view: ViewSettings) -> tuple[Mat, list[Place]]:
    """Lay a mat whose views are all unique, and tell what was found at each place.

    Args:
        settings: what the mat is like.
        seed: the same seed lays the same mat.
        view: how much of the floor the camera sees, and how well.

    Raises:
        FloorLocalizerError: no such mat was found; the line tells what to change.
    """
    for trial in range(_TRIALS):
        mat = lay_mat(settings, seed, trial)
        floor = index_map(mat.dot_map)
        places = list(inspect_places(floor, list_places(floor.grid, view), view, LocalizerSettings()))
        bad = [place for place in places if place.kind is not PlaceKind.UNIQUE]
        if not bad:
            return mat, places
    raise FloorLocalizerError(
        f'--density: {len(bad)} of {len(places)} views of {1e3 * view.view_size:.0f} mm are not unique '
        f'({bad[0].dots} dots at ({bad[0].x:.3f}, {bad[0].y:.3f}) m: {bad[0].kind.value}); '
        'give more dots, or a larger --view-size if the camera sees more'
    )
