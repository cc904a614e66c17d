"""Trajectory files in TUM format: ``stamp x y z qx qy qz qw`` per line, seconds and metres."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from shirube_bags.errors import TumFileError
from shirube_bags.stamps import stamp_from_text, text_from_stamp
from shirube_bags.trajectory import Trajectory, find_malformed_pose, make_trajectory
from shirube_core.files import write_text

COLUMNS = 'stamp x y z qx qy qz qw'


def load_tum(path: Path | str) -> Trajectory:
    """Load a TUM file; empty lines and lines that start with ``#`` are skipped.

    Raises:
        TumFileError: the file is missing, empty, or a line is malformed or has NaN.
    """
    try:
        lines = Path(path).read_text(encoding='utf-8').splitlines()
    except (OSError, UnicodeDecodeError) as fault:
        reason = fault.strerror if isinstance(fault, OSError) else 'not a text file'
        raise TumFileError(
            f'{path}: cannot be read ({reason}); give a text file of lines "{COLUMNS}"'
        ) from fault
    rows: dict[int, list[float]] = {}
    numbers: list[int] = []
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith('#'):
            continue
        try:
            stamp_ns, values = parse_tum_line(line)
        except ValueError as fault:
            raise TumFileError(f'{path}, line {number}: {fault}') from fault
        if stamp_ns in rows:
            raise TumFileError(f'{path}, line {number}: duplicate stamp; keep one of the two lines')
        rows[stamp_ns] = values
        numbers.append(number)
    if not rows:
        raise TumFileError(f'{path}: has no poses; give lines "{COLUMNS}"')
    poses = np.array(list(rows.values()))
    malformed = find_malformed_pose(poses[:, :3], poses[:, 3:])
    if malformed is not None:
        raise TumFileError(f'{path}, line {numbers[malformed[0]]}: {malformed[1]}; remove such poses')
    return make_trajectory(list(rows), poses[:, :3], poses[:, 3:])


def parse_tum_line(line: str) -> tuple[int, list[float]]:
    """Return the stamp [ns] and the seven numbers of the pose in one line.

    Raises:
        ValueError: the line does not have eight numbers.
    """
    fields = line.split()
    if len(fields) != 8:
        raise ValueError(f'{len(fields)} fields instead of 8; write "{COLUMNS}" with blanks between')
    try:
        return stamp_from_text(fields[0]), [float(field) for field in fields[1:]]
    except ValueError as fault:
        raise ValueError(f'{fault}; write "{COLUMNS}" as numbers') from fault


def save_tum(path: Path | str, trajectory: Trajectory) -> None:
    """Write a TUM file atomically; stamps keep their nanoseconds, poses all digits.

    Raises:
        TumFileError: the file cannot be written.
    """
    rows = zip(trajectory.stamps_ns, trajectory.positions, trajectory.quaternions, strict=True)
    lines = [f'# {COLUMNS}\n']
    for stamp_ns, position, quaternion in rows:
        numbers = ' '.join(repr(float(number)) for number in (*position, *quaternion))
        lines.append(f'{text_from_stamp(stamp_ns)} {numbers}\n')
    try:
        write_text(path, ''.join(lines))
    except OSError as fault:
        raise TumFileError(
            f'{path}: cannot be written ({fault.strerror}); choose a writable place'
        ) from fault
