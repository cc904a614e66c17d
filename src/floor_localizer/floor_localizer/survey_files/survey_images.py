"""Images of a survey that any process with access to the files can read: batches of pixels, and dots in one file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, overload

import numpy as np

from floor_localizer.core.arrays import Ints, Pixels
from floor_localizer.core.survey.survey_image import SurveyImage
from shirube_bags.bag_reader import BagReader
from shirube_core.files import atomic_write
from shirube_core.geometry import SE2, PinholeCamera
from shirube_ros.camera.files import load_image
from shirube_ros.camera.image import array_from_compressed_image, array_from_image
from shirube_ros.errors import ImageFileError, MessageError

_COLUMNS = 7
_ROW = _COLUMNS * np.dtype(np.float64).itemsize


@dataclass(frozen=True)
class Frame:
    """An image that is not read yet: its human-readable name, and the robot's pose by odometry."""

    name: str
    T_odom_base: SE2


@dataclass(frozen=True)
class FileImageBatch:
    """Image files: index in the survey and path of each, and the camera that took them."""

    files: tuple[tuple[int, Path], ...]
    camera: PinholeCamera

    def __iter__(self) -> Iterator[tuple[int, Pixels | str]]:
        """Yield index and pixels of each image, or a one-line error message instead of the pixels."""
        for index, path in self.files:
            try:
                yield index, _check_size(load_image(path), self.camera, str(path))
            except ImageFileError as fault:
                yield index, str(fault)


@dataclass(frozen=True)
class BagImageBatch:
    """Images of a time interval of a bag.

    Attributes:
        path: path of the bag.
        topic: topic of the images.
        begin_ns: receive time of the first image; the bag is not read before it [ns].
        end_ns: receive time of the last image [ns].
        first: index in the survey of the first image in the interval.
        wanted: indices of the images to read.
        camera: camera that took the images.
    """

    path: Path
    topic: str
    begin_ns: int
    end_ns: int
    first: int
    wanted: tuple[int, ...]
    camera: PinholeCamera

    def __iter__(self) -> Iterator[tuple[int, Pixels | str]]:
        """Yield index and pixels of each image, or a one-line error message instead of the pixels."""
        wanted = set(self.wanted)
        with BagReader(self.path) as bag:
            messages = bag.messages_between([self.topic], self.begin_ns, self.end_ns)
            for index, raw in enumerate(messages, start=self.first):
                if index in wanted:
                    yield (index, self._pixels(bag.decode(raw), is_compressed=raw.msgtype.endswith('CompressedImage')))

    def _pixels(self, message: Any, *, is_compressed: bool) -> Pixels | str:
        read = array_from_compressed_image if is_compressed else array_from_image
        try:
            return _check_size(read(message, self.topic), self.camera, self.topic)
        except MessageError as fault:
            return str(fault)


ImageBatch = Iterable[tuple[int, Pixels | str]]
"""Index and pixels of each image in order, or a one-line error message instead of the pixels."""


def _check_size(pixels: Pixels, camera: PinholeCamera, name: str) -> Pixels | str:
    height, width = pixels.shape[:2]
    if (width, height) == (camera.width, camera.height):
        return pixels
    return (
        f'{name}: is {width} x {height} px, the calibration is for {camera.width} x {camera.height} px; '
        'survey with images of one size'
    )


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
    ends: Ints

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
    """Write images to a file; raises `OSError`."""
    frames, counts = [], []
    with atomic_write(path) as file:
        for image in images:
            table = np.column_stack([image.directions, image.points, image.sigmas, image.diameters])
            file.write(table.tobytes())
            frames.append(Frame(image.name, image.T_odom_base))
            counts.append(len(image))
    return PackedImages(path, frames, np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]))
