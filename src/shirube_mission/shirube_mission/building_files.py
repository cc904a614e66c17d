"""What the robot knows of the building, as files: the surveyed floor, the lamps, the taught places, the key."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dot_map import DotMap
from floor_localizer.files.dot_map_file import write_indexed_map
from scene_simulator.lamp_bag import write_beacons
from scene_simulator.mission_floor import surveyed_floor
from scene_simulator.mission_lamps import LAMP_RADIUS, LAMPS
from shirube_mission.place_teaching import teach_places
from vlc_beacon.files.counter_file import CounterFile

_PUBLIC_KEY = 'b3' * 32
"""Signs the orders of simulated lamps, so that a seed always gives the same light; it is no secret."""

_SURVEY_SIGMA = 5e-5
"""How far the surveyed centres and diameters are off, standard deviation [m]."""


@dataclass(frozen=True)
class BuildingFiles:
    """Where the files are.

    Attributes:
        folder: that holds them.
    """

    folder: Path

    @property
    def dot_map(self) -> Path:
        """The surveyed floor, indexed."""
        return self.folder / 'floor.dotmap'

    @property
    def beacons(self) -> Path:
        """The lamps."""
        return self.folder / 'beacons.yaml'

    @property
    def places(self) -> Path:
        """Folder of the taught places."""
        return self.folder / 'places'

    @property
    def key(self) -> Path:
        """With which orders are signed."""
        return self.folder / 'mission.key'

    @property
    def counters(self) -> Path:
        """The counters of the orders."""
        return self.folder / 'counters.yaml'


def write_building(folder: Path) -> BuildingFiles:
    """Write the files and return where they are; what is there already of an unchanged building stays.

    Args:
        folder: made if it is not there.

    Raises:
        OSError: the folder cannot be written to.
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
    CounterFile(files.counters).renew(0)
    return files
