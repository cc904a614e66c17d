"""The node's parameters, except those of the matching, which are in the core's LocalizerSettings."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from floor_localizer.core.settings import DotDetectorSettings, TrackerSettings
from shirube_core.settings import setting
from shirube_ros.camera_settings import CameraSettings

DEMO_MAP = Path(__file__).parents[1] / 'maps' / 'demo_floor.csv'


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
