"""Poses of the localizers on the recorded bags, with odometry and ground truth."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from floor_localizer.commands.locate import locate as locate_floor
from floor_localizer.commands.locate import make_parser as floor_parser
from floor_localizer.core.fix import Fix
from pose_arbiter.core.kalman_filter import Covariance, diagonal
from shirube_bags.bag_reader import BagReader
from shirube_bags.trajectory import Trajectory, can_interpolate, interpolate, planar_poses
from shirube_bags.trajectory_files import header_stamp, load_bag_trajectory
from shirube_core.geometry import SE2
from shirube_ros.message_conversion import planar_pose_with_covariance
from stereo_landmark.commands.locate import locate as locate_landmarks
from stereo_landmark.commands.locate import make_parser as landmark_parser
from stereo_landmark.commands.teach import main as teach
from vlc_beacon.commands.locate import locate as locate_lamps
from vlc_beacon.commands.locate import make_parser as lamp_parser

BAGS = Path(__file__).parents[1] / 'bags'
CORRIDORS = ('teach', 'left', 'right', 'light', 'hidden', 'moved')
_GAP_MAX = 400_000_000  # between true poses [ns]
_MISSION_TOPICS = tuple(
    f'/{name}/pose_with_covariance' for name in ('floor_localizer', 'vlc_beacon', 'stereo_landmark')
)
_POSE_SIGMAS = 0.003, 0.002  # of the poses in room_drive, by its README [m, rad]


@dataclass(frozen=True)
class PoseSample:
    """A pose of a source: stamp [ns], ``T_map_base`` and its covariance."""

    stamp: int
    pose: SE2
    noise: Covariance


@dataclass(frozen=True)
class RecordedDrive:
    """One bag.

    Attributes:
        name: bag name.
        sources: poses of each source, sorted by stamp.
        odometry: stamps [ns] and ``T_odom_base``.
        truth: the true poses.
    """

    name: str
    sources: list[list[PoseSample]]
    odometry: list[tuple[int, SE2]]
    truth: Trajectory

    @property
    def best(self) -> int:
        """The source whose positions have the least root mean square error."""
        squares = [np.nanmean(self.errors_of(source)[:, 0] ** 2) for source in self.sources]
        return int(np.argmin(squares))

    def errors_of(self, source: Sequence[PoseSample]) -> NDArray[np.float64]:
        """Return the errors of a source's poses; see `errors_at`."""
        return self.errors_at([(o.stamp, o.pose) for o in source])

    def errors_at(self, poses: Sequence[tuple[int, SE2]]) -> NDArray[np.float64]:
        """Return the errors of poses, shape (n, 2): distance [m] and turn [rad]; NaN where the truth is not known."""
        wanted = np.array([stamp for stamp, _ in poses], dtype=np.int64)
        known = can_interpolate(self.truth, wanted, _GAP_MAX)
        errors = np.full((len(wanted), 2), np.nan)
        if known.any():
            true = planar_poses(interpolate(self.truth, wanted[known]))
            estimated = np.array([(pose.x, pose.y, pose.yaw) for _, pose in poses])[known]
            errors[known, 0] = np.hypot(*(estimated - true)[:, :2].T)
            errors[known, 1] = np.abs(np.remainder(estimated[:, 2] - true[:, 2] + np.pi, 2 * np.pi) - np.pi)
        return errors


def recorded_drives(names: Sequence[str] = ()) -> list[RecordedDrive]:
    """Return the drives of the bags, all or the named ones."""
    rolling = '--shutter', 'rolling', '--exposure-time', '0.00006'
    makers: dict[str, Callable[[Path], list[list[PoseSample]]]] = {
        'floor_drive': lambda bag: [_floor(bag)],
        'lamp_drive': lambda bag: [_lamps(bag)],
        'lamp_drive_rolling': lambda bag: [_lamps(bag, *rolling)],
        'room_drive': lambda bag: [_room(bag)],
        'mission': _mission,
    }
    drives = [_drive(name, make(BAGS / name)) for name, make in makers.items() if not names or name in names]
    corridors = [k for k in CORRIDORS if not names or f'corridor_{k}' in names]
    if corridors:
        with tempfile.TemporaryDirectory() as folder:
            teach(['--batch', str(BAGS / 'corridor_teach/lesson.yaml'), '--places', folder])
            drives += [_drive(f'corridor_{k}', [_corridor(BAGS / f'corridor_{k}', Path(folder))]) for k in corridors]
    return drives


def _drive(name: str, sources: list[list[PoseSample]]) -> RecordedDrive:
    with BagReader(BAGS / name) as bag:
        truth, odometry = load_bag_trajectory(bag, '/ground_truth'), load_bag_trajectory(bag, '/odom')
    return RecordedDrive(name, sources, _stamped(odometry), truth)


def _floor(bag: Path) -> list[PoseSample]:
    options = floor_parser().parse_args(['--map', '', '--bag', str(bag)])
    options.map = ''  # the demo floor, which is that of the bag
    return [
        PoseSample(image.stamp_ns, image.result.T_map_base, image.result.covariance)
        for image in locate_floor(options)
        if isinstance(image.result, Fix)
    ]


def _lamps(bag: Path, *more: str) -> list[PoseSample]:
    beacons = str(bag / 'beacons.yaml')
    arguments = ['--beacons', beacons, '--bag', str(bag), '--camera-xyz', '0', '0', '0', *more]
    return [
        PoseSample(image.stamp_ns, image.fix.T_map_base, image.fix.planar_covariance)
        for image in locate_lamps(lamp_parser().parse_args(arguments))
        if image.fix is not None
    ]


def _corridor(bag: Path, places: Path) -> list[PoseSample]:
    arguments = ['--places', str(places), '--bag', str(bag), '--camera-xyz', '0.1', '0.12', '1.25']
    samples = []
    for frame in locate_landmarks(landmark_parser().parse_args(arguments)):
        fix = frame.fix
        if fix is not None and fix.T_map_base is not None and fix.map_covariance is not None:
            samples.append(PoseSample(frame.stamp_ns, fix.T_map_base, fix.map_covariance))
    return samples


def _room(bag: Path) -> list[PoseSample]:
    with BagReader(bag) as reader:
        poses = load_bag_trajectory(reader, '/pose')
    noise = diagonal(_POSE_SIGMAS[0] ** 2, _POSE_SIGMAS[1] ** 2)
    return [PoseSample(stamp, pose, noise) for stamp, pose in _stamped(poses)]


def _stamped(poses: Trajectory) -> list[tuple[int, SE2]]:
    planar = [SE2(*pose) for pose in planar_poses(poses).tolist()]
    return list(zip(poses.stamps_ns.tolist(), planar, strict=True))


def _mission(bag: Path) -> list[list[PoseSample]]:
    """Return the recorded poses of the localizers."""
    sources = []
    with BagReader(bag) as reader:
        for topic in _MISSION_TOPICS:
            estimated = []
            for raw in reader.messages([topic]):
                message = reader.decode(raw)
                pose, noise = planar_pose_with_covariance(message.pose, topic)
                estimated.append(PoseSample(header_stamp(raw.raw), pose, noise))
            sources.append(sorted(estimated, key=lambda sample: sample.stamp))
    return sources
