"""Files with the robot's prior knowledge: dot map, lamps, taught places and command key."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.files.dot_map_file import write_indexed_map
from scene_simulator.lamp_bag import write_beacons
from scene_simulator.mission_floor import surveyed_floor
from scene_simulator.mission_lamps import LAMP_RADIUS, LAMPS
from shirube_bringup.place_teaching import teach_places
from vlc_beacon.files.counter_file import CounterFile

_PUBLIC_KEY = 'b3' * 32
"""Key that signs the commands of the simulated lamps; fixed, so that a seed gives the same light. Not secret."""

_SURVEY_SIGMA = 5e-5
"""Standard deviation of the surveyed centres and diameters [m]."""


@dataclass(frozen=True)
class BuildingFiles:
    """Paths of the files.

    Attributes:
        folder: folder of the files.
    """

    folder: Path

    @property
    def dot_map(self) -> Path:
        """Indexed dot map."""
        return self.folder / 'floor.dotmap'

    @property
    def beacons(self) -> Path:
        """Beacon file of the lamps."""
        return self.folder / 'beacons.yaml'

    @property
    def places(self) -> Path:
        """Folder of the taught places."""
        return self.folder / 'places'

    @property
    def key(self) -> Path:
        """Key that signs commands."""
        return self.folder / 'mission.key'

    @property
    def counters(self) -> Path:
        """Counters of the commands."""
        return self.folder / 'counters.yaml'


def write_building(folder: Path) -> BuildingFiles:
    """Write the files that do not exist yet and return their paths.

    Args:
        folder: folder of the files, created if needed.

    Raises:
        OSError: the folder is not writable.
    """
    files = BuildingFiles(folder)
    files.places.mkdir(parents=True, exist_ok=True)
    if not files.dot_map.exists():
        floor = surveyed_floor()
        rng = np.random.default_rng(1)
        points = floor.points + rng.normal(0.0, _SURVEY_SIGMA, floor.points.shape)
        surveyed = DotMap(points, floor.diameters + rng.normal(0.0, _SURVEY_SIGMA, len(floor)))
        write_indexed_map(files.dot_map, surveyed, index_map(surveyed))
    write_beacons(list(LAMPS.items()), LAMP_RADIUS, files.beacons)
    if not any(files.places.glob('*.yaml')):
        teach_places(files.places)
    if not files.key.exists():
        files.key.touch(0o600)
        files.key.write_text(f'{_PUBLIC_KEY}\n')
    CounterFile(files.counters).reset(0)
    return files
