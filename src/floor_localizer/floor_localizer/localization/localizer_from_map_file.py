"""The node's parameters, a localizer created from them and the map file, and the compilation of its kernels."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from floor_localizer.core.arrays import Floats
from floor_localizer.core.constellation.indexed_map import IndexedMap, index_map
from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.dots import DetectedDots, DotMap
from floor_localizer.core.fix import PosePrior
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.mount_check import check_mount
from floor_localizer.core.settings import DotDetectorSettings, LocalizerSettings, TrackerSettings
from floor_localizer.files.dot_map_file import load_indexed_map
from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from shirube_core.settings import setting
from shirube_ros.camera.settings import CameraSettings

_DOTS = 200
_SIDE = 0.2  # side of the synthetic floor [m]
_HALF_VIEW = 0.04  # half the width of the view [m]
_POSE = SE2(_SIDE / 2.0, _SIDE / 2.0, 0.3)


def compile_kernels() -> None:
    """Extract dots, index a floor, and locate views."""
    _extract_dots()
    _search()


def _extract_dots() -> None:
    """Extract dots from a grey and a colour image."""
    image = np.full((235, 235), 200, dtype=np.uint8)
    for u, v in _camera_view()[2].astype(int):
        image[max(v - 3, 0) : v + 3, max(u - 3, 0) : u + 3] = 40
    detector = DotDetector()
    detector.detect(image)
    detector.detect(np.dstack([image, image, image]))


def _search() -> None:
    """Index a floor, locate views with and without a prior."""
    floor, camera, pixels = _camera_view()
    indexed = index_map(floor)
    localizer = FloorLocalizer(indexed, CameraMount())
    matching = _as_dots(pixels)
    unmatched = _as_dots(np.random.default_rng(1).uniform(0.0, 234.0, (20, 2)))
    localizer.locate_dots(matching, camera)
    localizer.locate_dots(matching, camera, PosePrior(_POSE, 0.01, 0.1))
    localizer.locate_dots(unmatched, camera)


def _camera_view() -> tuple[DotMap, PinholeCamera, Floats]:
    """Return a synthetic floor, a camera and the floor's dots in its image, shape (n, 2) [px]."""
    floor = np.random.default_rng(0).uniform(0.0, _SIDE, (_DOTS, 2))
    points = _POSE.inverse().transform(floor)
    points = points[(np.abs(points) < _HALF_VIEW).all(axis=1)]
    camera = PinholeCamera(235, 235, 339.44, 339.44, 117.0, 117.0)
    pixels = camera.pixels_from_points(CameraMount().camera_points_from_floor(points))
    return DotMap(floor, np.full(_DOTS, math.nan)), camera, pixels


def _as_dots(pixels: Floats) -> DetectedDots:
    return DetectedDots(pixels, np.full(len(pixels), 6.0), np.full(len(pixels), 0.1))


DEMO_MAP = Path(__file__).parents[1] / 'maps' / 'demo_floor.csv'
STARTUP_NOTICE = 'loading the map and the numba kernels (the very first start compiles them, about 1 min)'
"""Message at the start."""


@dataclass(frozen=True)
class NodeSettings(CameraSettings):
    """Camera mount, frames and map; dot detection and tracking in groups."""

    map_file: str = setting('', 'dot map of the floor, CSV or binary; empty for the demo floor')
    dots: DotDetectorSettings = field(default_factory=DotDetectorSettings)
    tracker: TrackerSettings = field(default_factory=TrackerSettings)

    @property
    def map_path(self) -> Path:
        """The dot map to load."""
        return Path(self.map_file).expanduser() if self.map_file else DEMO_MAP


def localizer_from_map_file(
    node_settings: NodeSettings, settings: LocalizerSettings, report: Callable[[str], object]
) -> FloorLocalizer:
    """Return a localizer for the map of the settings, with compiled kernels; report the size of the map in one line.

    Raises:
        FloorLocalizerError: a map that is missing, malformed or not in metres, or a camera that does not look at
            the floor.
    """
    check_mount(node_settings.mount)  # before the slow steps
    floor = load_indexed_map(node_settings.map_path)
    report(_describe(floor))
    compile_kernels()
    return FloorLocalizer(floor, node_settings.mount, settings, DotDetector(node_settings.dots))


def _describe(floor: IndexedMap) -> str:
    arrays = [part for part in (*floor.grid, *floor.index, *floor.addresses) if isinstance(part, np.ndarray)]
    megabytes = sum(array.nbytes for array in arrays) / 1e6
    levels = ', '.join(level.name for level in floor.levels)
    text = f'map of {len(floor.grid.points)} dots, {len(floor.index.entries)} constellations, {megabytes:.0f} MB'
    return f'{text}, levels: {levels}' if levels else text
