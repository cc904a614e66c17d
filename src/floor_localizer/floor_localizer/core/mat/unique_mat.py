"""Generate a mat on which every view is unique, checked with the search of the localizer."""

from __future__ import annotations

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.mat.mat_settings import MatSettings
from floor_localizer.core.mat.random_mat import Mat, generate_mat
from floor_localizer.core.settings import LocalizerSettings
from floor_localizer.core.uniqueness import Place, PlaceKind, ViewSettings, inspect_places, list_places

_TRIALS = 5


def generate_unique_mat(settings: MatSettings, seed: int, view: ViewSettings) -> tuple[Mat, list[Place]]:
    """Generate a mat whose views are all unique; return it with the inspected places.

    Args:
        settings: settings of the mat.
        seed: seed; the same seed gives the same mat.
        view: size and quality of the camera's view.

    Raises:
        FloorLocalizerError: no such mat was found; the message names the option to change.
    """
    for trial in range(_TRIALS):
        mat = generate_mat(settings, seed, trial)
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
