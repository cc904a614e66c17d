"""The recorded drive under lamps, read as the node reads it: `./shirube bench lamp_drive [--picture FILE]`.

Prints when lamps and pose were found, how far the poses are from the truth, and which commands were obeyed where.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _lamp_drive_picture import draw_lamp_drive
from numpy.typing import NDArray
from tqdm import tqdm

from shirube_bags.bag_reader import BagReader
from shirube_bags.bag_trajectory import load_bag_trajectory
from shirube_bags.error_table import planar_poses
from shirube_bags.trajectory import interpolate
from shirube_core.geometry import CameraMount
from vlc_beacon.bag_localization import BagLocalization, choose_topics
from vlc_beacon.core.authorization.counters import Counters
from vlc_beacon.core.authorization.decision import Accepted
from vlc_beacon.core.packet.command_packet import Operation
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.receiver.beacon_receiver import BeaconReceiver, ReceiverOutput
from vlc_beacon.core.settings import AuthorizationSettings, ReceiverSettings
from vlc_beacon.files.counter_file import CounterFile
from vlc_beacon.files.pose_table import LocatedImage
from vlc_beacon.node_settings import NodeSettings, authorizer_from_settings, beacons_from_settings

BAG = Path(__file__).parents[1] / 'bags' / 'lamp_drive'
ZONE_RADIUS = 0.3
"""The lamps of the paper's room are 1.8 m apart, and it turns right under them [m]."""
SPEED_LIMIT = 0.25


@dataclass(frozen=True)
class AcceptedCommand:
    """A command that was accepted: the index of the image, and the words for it."""

    image: int
    text: str


@dataclass(frozen=True)
class LampDrive:
    """What became of each image.

    Attributes:
        seconds: shape (n,), since the first image [s].
        poses: shape (n, 3), x, y [m], yaw [rad]; NaN where there is none.
        sigmas: shape (n,), stated standard deviation of the position along its worst direction [m].
        truth: shape (n, 3).
        identified: shape (n,), how many lamps with a name were in view.
        accepted_commands: the commands.
        beacons: the lamps of the file.
    """

    seconds: NDArray[np.float64]
    poses: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    truth: NDArray[np.float64]
    identified: NDArray[np.int64]
    accepted_commands: list[AcceptedCommand]
    beacons: list[Beacon]

    @property
    def errors(self) -> NDArray[np.float64]:
        """Shape (n,), in the plane [m]; NaN where there is no pose."""
        return np.asarray(np.hypot(*(self.poses - self.truth)[:, :2].T))

    @property
    def heading_errors(self) -> NDArray[np.float64]:
        """Shape (n,) [rad]; NaN where there is no pose."""
        return np.angle(np.exp(1j * (self.poses - self.truth)[:, 2]))


def read_drive(folder: Path) -> LampDrive:
    """Read the bag with its key; the counters live in a folder of their own."""
    key = Path(shutil.copy(BAG / 'demo_key', folder))
    key.chmod(0o600)
    counters = folder / 'counters.json'
    CounterFile(counters).write(Counters())
    settings = NodeSettings(
        beacons_file=str(BAG / 'beacons.yaml'), key_file=str(key), counter_file=str(counters)
    )
    beacons = beacons_from_settings(settings)
    authorizer = authorizer_from_settings(
        settings, AuthorizationSettings(zone_radius=ZONE_RADIUS, speed_limit=SPEED_LIMIT), beacons
    )
    mount = CameraMount((0.0, 0.0, 0.0), (0.0, 0.0, 0.5 * np.pi))
    with BagReader(BAG) as bag:
        localization = BagLocalization(
            bag,
            choose_topics(bag, None, None, None, None),
            lambda: BeaconReceiver(beacons, mount, authorizer, ReceiverSettings()),
        )
        images = list(tqdm(localization.run(), desc='images', unit=''))
        truth = load_bag_trajectory(bag, '/ground_truth')
    stamps = np.array([image.stamp_ns for image in images])
    return LampDrive(
        (stamps - stamps[0]) * 1e-9,
        np.array([_pose(image) for image in images]),
        np.array([_sigma(image) for image in images]),
        planar_poses(interpolate(truth, stamps)),
        np.array([_identified(image) for image in images]),
        [AcceptedCommand(i, text) for i, image in enumerate(images) for text in _accepted_command(image)],
        beacons,
    )


def _pose(image: LocatedImage) -> tuple[float, float, float]:
    if image.fix is None:
        return (np.nan, np.nan, np.nan)
    pose = image.fix.T_map_base
    return pose.x, pose.y, pose.yaw


def _sigma(image: LocatedImage) -> float:
    if image.fix is None:
        return np.nan
    return float(np.sqrt(np.linalg.eigvalsh(image.fix.covariance[:2, :2])[-1]))


def _identified(image: LocatedImage) -> int:
    if not isinstance(image.result, ReceiverOutput):
        return 0
    return sum(lamp.beacon is not None and lamp.sample.is_lit for lamp in image.result.lamps)


def _accepted_command(image: LocatedImage) -> list[str]:
    if not isinstance(image.result, ReceiverOutput):
        return []
    accepted = [v.outcome.command for v in image.result.decisions if isinstance(v.outcome, Accepted)]
    return [
        f'{Operation(command.operation).label} {command.value:g} of lamp {command.beacon}'
        for command in accepted
    ]


def report(drive: LampDrive) -> str:
    """Return the figures as text."""
    found = np.flatnonzero(np.isfinite(drive.errors))
    first = found[0]
    after = np.arange(len(drive.errors)) >= first
    errors, degrees = drive.errors[found], np.degrees(np.abs(drive.heading_errors[found]))
    lines = [
        f'{len(drive.errors)} images of {drive.seconds[-1]:.1f} s; the first pose after {drive.seconds[first]:.1f} s',
        f'images with a pose from then on: {100.0 * len(found) / after.sum():.1f} %',
        (
            f'position error [mm]: median {1e3 * np.median(errors):.1f}, 95 % {1e3 * np.quantile(errors, 0.95):.1f}, '
            f'max {1e3 * errors.max():.1f}; rms error / stated sigma {_ratio(drive, found):.2f}'
        ),
        (
            f'heading error [deg]: median {np.median(degrees):.2f}, 95 % {np.quantile(degrees, 0.95):.2f}, '
            f'max {degrees.max():.2f}'
        ),
        'with lamps in view: '
        + ', '.join(
            f'{count}: {100.0 * (drive.identified[after] == count).mean():.0f} %' for count in range(5)
        ),
    ]
    for each in drive.accepted_commands:
        x, y, _ = drive.truth[each.image]
        lines.append(f'{drive.seconds[each.image]:6.2f} s at ({x:.2f}, {y:.2f}) m: {each.text}')
    return '\n'.join(lines)


def _ratio(drive: LampDrive, found: NDArray[np.int64]) -> float:
    """Return the rms of the errors in the plane over what the covariances say of them."""
    return float(np.sqrt(np.mean(drive.errors[found] ** 2) / np.mean(2.0 * drive.sigmas[found] ** 2)))


def main() -> int:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(prog='lamp_drive', description=__doc__.splitlines()[0])
    parser.add_argument('--picture', type=Path, metavar='PNG', help='draw the drive there')
    options = parser.parse_args()
    os.umask(0o077)
    with tempfile.TemporaryDirectory() as folder:
        drive = read_drive(Path(folder))
    print(report(drive))
    if options.picture is not None:
        draw_lamp_drive(options.picture, drive)
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
