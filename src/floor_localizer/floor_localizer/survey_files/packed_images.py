"""The dots of all images of a survey in one file, read on demand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import overload

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.survey_image import SurveyImage
from floor_localizer.survey_files.survey_source import Frame
from shirube_core.files import atomic_write

_COLUMNS = 7
_ROW = _COLUMNS * np.dtype(np.float64).itemsize


@dataclass(frozen=True)
class PackedImages(Sequence[SurveyImage]):
    """Images in a file, readable by any worker that sees the file.

    Attributes:
        path: path of the file, which has a row of seven numbers for each dot.
        frames: names and odometry of the images.
        ends: first row of each image, then the number of rows, shape (n + 1,).
    """

    path: Path
    frames: list[Frame]
    ends: NDArray[np.int64]

    def __len__(self) -> int:
        """Return the number of images."""
        return len(self.frames)

    @overload
    def __getitem__(self, index: int) -> SurveyImage: ...
    @overload
    def __getitem__(self, index: slice) -> PackedImages: ...
    def __getitem__(self, index: int | slice) -> SurveyImage | PackedImages:
        """Read an image; or return the images of a contiguous slice, without reading them."""
        if isinstance(index, slice):
            first, last, _ = index.indices(len(self))
            return PackedImages(self.path, self.frames[first:last], self.ends[first : last + 1])
        frame = self.frames[index]
        begin, end = self.ends[range(len(self))[index] :][:2].tolist()
        table = np.fromfile(self.path, count=_COLUMNS * (end - begin), offset=_ROW * begin)
        rows = table.reshape(-1, _COLUMNS)
        columns = (rows[:, :3], rows[:, 3:5], rows[:, 5], rows[:, 6])
        return SurveyImage(frame.name, frame.T_odom_base, *map(np.ascontiguousarray, columns))


def pack_images(path: Path, images: Iterable[SurveyImage]) -> PackedImages:
    """Write images to a file.

    Raises:
        OSError: the file cannot be written.
    """
    frames, counts = [], []
    with atomic_write(path) as file:
        for image in images:
            table = np.column_stack([image.directions, image.points, image.sigmas, image.diameters])
            file.write(table.tobytes())
            frames.append(Frame(image.name, image.T_odom_base))
            counts.append(len(image))
    return PackedImages(path, frames, np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]))
