"""CSV of the poses of images, with the failure reason of images without a pose."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from shirube_bags.stamps import text_from_stamp
from shirube_core.files import atomic_write
from vlc_beacon.core.receiver.beacon_receiver import ReceiverOutput
from vlc_beacon.located_image import LocatedImage

_POSE = ('x', 'y', 'z', 'yaw', 'sigma_x', 'sigma_y', 'sigma_z', 'sigma_yaw')
COLUMNS = ('image', 'stamp', *_POSE, 'lamps', 'beacons', 'used', 'anomalies', 'reason', 'detail')


def save_pose_table(path: Path, images: Sequence[LocatedImage]) -> None:
    """Write one line per image, in metres and radians, atomically.

    Raises:
        OSError: the file cannot be written.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator='\n')
    table.writerow(COLUMNS)
    for image in images:
        table.writerow([image.name, text_from_stamp(image.stamp_ns), *_fields(image)])
    with atomic_write(path) as file:
        file.write(text.getvalue().encode())


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
