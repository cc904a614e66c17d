"""The node's parameters, and a localizer created from them and the map file."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from floor_localizer.core.compile_kernels import compile_kernels
from floor_localizer.core.constellation.indexed_map import IndexedMap
from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.mount_check import check_mount
from floor_localizer.core.settings import DotDetectorSettings, LocalizerSettings, TrackerSettings
from floor_localizer.files.dot_map_file import load_indexed_map
from shirube_core.settings import setting
from shirube_ros.camera.settings import CameraSettings

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
