"""Results of images located offline, and their CSV files: poses, and messages of the lamps."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shirube_bags.stamps import text_from_stamp
from shirube_core.files import write_csv
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.receiver.beacon_receiver import ReceiverOutput


@dataclass(frozen=True)
class LocatedImage:
    """The image of a file or topic at a stamp [ns], and the receiver output or the error message."""

    name: str
    stamp_ns: int
    result: ReceiverOutput | str

    @property
    def fix(self) -> BeaconFix | None:
        """The pose, None if there is none."""
        if isinstance(self.result, ReceiverOutput) and isinstance(self.result.result, BeaconFix):
            return self.result.result
        return None

    @property
    def failure(self) -> str:
        """Reason for no pose, empty if there is one."""
        if isinstance(self.result, str):
            return self.result
        return '' if isinstance(self.result.result, BeaconFix) else self.result.result.reason.value


_POSE = ('x', 'y', 'z', 'yaw', 'sigma_x', 'sigma_y', 'sigma_z', 'sigma_yaw')
COLUMNS = ('image', 'stamp', *_POSE, 'lamps', 'beacons', 'used', 'anomalies', 'reason', 'detail')


def save_pose_table(path: Path, images: Sequence[LocatedImage]) -> None:
    """Write one line per image, in metres and radians, atomically; raises `OSError`."""
    rows = ([image.name, text_from_stamp(image.stamp_ns), *_fields(image)] for image in images)
    write_csv(path, COLUMNS, rows)


def save_messages(path: Path, images: Sequence[LocatedImage]) -> int:
    """Write one line per message of a lamp, atomically; return their number; raises `OSError`."""
    rows = [
        [text_from_stamp(image.stamp_ns), '' if m.sender is None else str(m.sender), m.to_json()]
        for image in images
        if isinstance(image.result, ReceiverOutput)
        for m in image.result.messages
    ]
    write_csv(path, ('stamp', 'beacon', 'data'), rows)
    return len(rows)


def _fields(image: LocatedImage) -> list[str]:
    if not isinstance(image.result, ReceiverOutput):
        return [*[''] * (len(_POSE) + 4), image.failure, '']
    lamps, fix = image.result.lamps, image.fix
    names = ' '.join(str(name) for name in sorted(lamp.beacon for lamp in lamps if lamp.beacon is not None))
    anomalies = ' '.join(f'{anomaly.id}:{anomaly.kind.value}' for anomaly in image.result.result.anomalies)
    if fix is None:
        detail = getattr(image.result.result, 'detail', '')
        return [*[''] * len(_POSE), str(len(lamps)), names, '', anomalies, image.failure, detail]
    pose, sigmas = fix.T_map_base, np.sqrt(np.diag(fix.covariance))
    numbers = (pose.x, pose.y, fix.height, pose.yaw, *sigmas.tolist())
    poses = [f'{number:.6f}' for number in numbers]
    return [*poses, str(len(lamps)), names, str(int(fix.used.sum())), anomalies, '', '']
