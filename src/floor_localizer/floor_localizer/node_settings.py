"""The node's own parameters; those of the method are the settings of the core."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from shirube_ros.camera_settings import CameraSettings
from shirube_settings import setting

DEMO_MAP = Path(__file__).parent / 'maps' / 'demo_floor.csv'


@dataclass(frozen=True)
class NodeSettings(CameraSettings):
    """Where the camera sits, which frames the poses connect, which map is used."""

    map_file: str = setting('', 'dot map of the floor, CSV or binary; empty takes the demo floor')

    @property
    def map_path(self) -> Path:
        """The dot map to load."""
        return Path(self.map_file).expanduser() if self.map_file else DEMO_MAP
