"""Writes the errors of each pose to a CSV file."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shirube_bags.stamps import text_from_stamp
from shirube_bags.trajectory import Trajectory
from shirube_bags.trajectory_errors import TrajectoryErrors
from shirube_core.files import write_text

COLUMNS = (
    'stamp', 'position_error', 'heading_error',
    'x', 'y', 'yaw', 'reference_x', 'reference_y', 'reference_yaw',
)  # fmt: skip


def save_error_table(path: Path | str, errors: TrajectoryErrors) -> None:
    """Write one line per compared pose, in seconds, metres and radians.

    Raises:
        OSError: the file cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(COLUMNS)
    numbers = np.column_stack(
        [errors.position, errors.heading, planar_poses(errors.estimate), planar_poses(errors.reference)]
    )
    for stamp_ns, row in zip(errors.estimate.stamps_ns, numbers, strict=True):
        writer.writerow([text_from_stamp(stamp_ns), *(f'{number:.9g}' for number in row)])
    write_text(path, text.getvalue())


def planar_poses(trajectory: Trajectory) -> NDArray[np.float64]:
    """Return x [m], y [m] and yaw [rad] of each pose, shape (n, 3)."""
    yaw = Rotation.from_quat(trajectory.quaternions).as_euler('xyz')[:, 2]
    return np.column_stack([trajectory.positions[:, :2], yaw])
