"""Writes localization results: a CSV file with all stereo pairs, and trajectories."""

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shirube_bags.stamps import text_from_stamp
from shirube_bags.trajectory import planar_trajectory
from shirube_bags.trajectory_files import save_tum
from shirube_core.files import write_csv
from shirube_core.geometry import SE2
from stereo_landmark.core.landmark_localizer import LandmarkFix
from stereo_landmark.core.pair.pair_stream import LocatedPair
from stereo_landmark.core.procedure.target_search import TargetDetection


@dataclass(frozen=True)
class LocatedFrame:
    """A stereo pair and its result.

    Attributes:
        name: file name or topic of the left image.
        stamp_ns: stamp of the pair [ns]; for files their index divided by the rate.
        outcome: localization result, or the error message if the pair was invalid.
    """

    name: str
    stamp_ns: int
    outcome: LocatedPair | str

    @property
    def fix(self) -> LandmarkFix | None:
        """Place and displacement, None without a fix."""
        if isinstance(self.outcome, LocatedPair) and isinstance(self.outcome.result, LandmarkFix):
            return self.outcome.result
        return None

    @property
    def failure(self) -> tuple[str, str]:
        """Reason why there is no fix, and its details; empty strings with a fix."""
        if isinstance(self.outcome, str):
            return self.outcome, ''
        result = self.outcome.result
        return ('', '') if isinstance(result, LandmarkFix) else (result.reason, result.detail)


_DISPLACEMENT = ('x', 'y', 'z', 'yaw', 'sigma_x', 'sigma_y', 'sigma_z', 'sigma_yaw')
_RESULT_COLUMNS = ('place', *_DISPLACEMENT, 'map_x', 'map_y', 'map_yaw', 'targets', 'points')
COLUMNS = ('image', 'stamp', *_RESULT_COLUMNS, 'reason', 'detail')
MAP_FILE = 'poses.tum'


def save_displacements(folder: Path, frames: Sequence[LocatedFrame]) -> list[Path]:
    """Write ``poses.csv`` with one line per stereo pair, and trajectories; return the files.

    ``poses.tum`` contains the poses in the map; ``displacements_<place>.tum`` contains the poses in the frame of one
    place. Stale trajectories of the previous run, listed in its ``poses.csv``, are removed after writing.

    Raises:
        OSError: the folder is not writable.
    """
    table = folder / 'poses.csv'
    existing = _existing_trajectories(table)
    in_map: dict[int, SE2] = {}
    in_places: dict[str, dict[int, SE2]] = {}
    for frame in frames:
        if frame.fix is None:
            continue
        in_places.setdefault(frame.fix.place.name, {})[frame.stamp_ns] = frame.fix.displacement.T_place_base
        if frame.fix.T_map_base is not None:
            in_map[frame.stamp_ns] = frame.fix.T_map_base
    files = {folder / f'displacements_{name}.tum': poses for name, poses in in_places.items()}
    if in_map:
        files[folder / MAP_FILE] = in_map
    for path, poses in files.items():
        flat = [(pose.x, pose.y, pose.yaw) for pose in poses.values()]
        save_tum(path, planar_trajectory(list(poses), flat))
    write_csv(table, COLUMNS, map(_row, frames))
    for stale in existing - files.keys():
        stale.unlink(missing_ok=True)
    return [table, *files]


def _existing_trajectories(table: Path) -> set[Path]:
    """Return the trajectories that belong to an existing table; none if it is missing or has another format."""
    try:
        lines = csv.DictReader(io.StringIO(table.read_text(encoding='utf-8')))
        rows = list(lines) if tuple(lines.fieldnames or ()) == COLUMNS else []
    except (OSError, ValueError, csv.Error):
        return set()
    names = {row['place'] for row in rows if re.fullmatch(r'[\w-]+', row['place'] or '')}
    files = {table.parent / f'displacements_{name}.tum' for name in names}
    return files | {table.parent / MAP_FILE} if any(row['map_x'] for row in rows) else files


def _row(frame: LocatedFrame) -> list[str]:
    found = [''] * len(_RESULT_COLUMNS) if frame.fix is None else _result_fields(frame.fix)
    return [frame.name, text_from_stamp(frame.stamp_ns), *found, *frame.failure]


def _result_fields(fix: LandmarkFix) -> list[str]:
    displacement = fix.displacement
    pose, in_map = displacement.T_place_base, fix.T_map_base
    numbers = (pose.x, pose.y, displacement.height, pose.yaw, *np.sqrt(np.diag(displacement.covariance)))
    map_numbers = () if in_map is None else (in_map.x, in_map.y, in_map.yaw)
    targets = ' '.join(each.target for each in fix.detections if isinstance(each, TargetDetection))
    return [
        fix.place.name,
        *(f'{number:.6f}' for number in numbers),
        *([f'{number:.6f}' for number in map_numbers] or [''] * 3),
        targets,
        str(len(displacement.names)),
    ]
