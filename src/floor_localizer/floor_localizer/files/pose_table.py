"""Results of images that were located without a running node, and their table as CSV."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from floor_localizer.core.fix import Fix, NoFix
from shirube_bags.stamps import text_from_stamp
from shirube_core.files import write_csv

COLUMNS = (
    *('image', 'stamp', 'x', 'y', 'yaw', 'sigma_x', 'sigma_y', 'sigma_yaw'),
    *('dots', 'matched', 'scale', 'roll', 'pitch', 'expected_chance_alignments', 'reason', 'detail', 'level'),
)


@dataclass(frozen=True)
class LocatedImage:
    """One image and its result.

    Attributes:
        name: name of the file or topic.
        stamp_ns: time of the image [ns]; for files, their index in seconds.
        result: the pose, the reason for no pose, or the error message of the image.
    """

    name: str
    stamp_ns: int
    result: Fix | NoFix | str

    @property
    def failure(self) -> str:
        """Reason for no pose, empty if there is one."""
        if isinstance(self.result, Fix):
            return ''
        return self.result if isinstance(self.result, str) else self.result.reason.value


def save_pose_table(path: Path, images: Sequence[LocatedImage]) -> None:
    """Write one line per image, in metres and radians, atomically; raises `OSError`."""
    rows = ([image.name, text_from_stamp(image.stamp_ns), *_fields(image)] for image in images)
    write_csv(path, COLUMNS, rows)


def _fields(image: LocatedImage) -> list[str]:
    result = image.result
    if isinstance(result, Fix):
        pose, sigmas = result.T_map_base, np.sqrt(np.diag(result.covariance))
        numbers = [
            *(f'{pose.x:.7f}', f'{pose.y:.7f}', f'{pose.yaw:.7f}'),
            *(f'{sigma:.7f}' for sigma in sigmas),
            *(str(len(result.dots)), str(int(result.matched.sum()))),
            *(f'{result.scale:.6f}', f'{result.tilt[0]:.6f}', f'{result.tilt[1]:.6f}'),
            f'{result.expected_chance_alignments:.3g}',
        ]
        return [*numbers, '', '', result.level]
    dots = str(len(result.dots)) if isinstance(result, NoFix) and result.dots is not None else ''
    detail = result.detail if isinstance(result, NoFix) else ''
    return [*[''] * 6, dots, *[''] * 5, image.failure, detail, '']
