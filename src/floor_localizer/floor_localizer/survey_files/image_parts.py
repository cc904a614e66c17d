"""Some of a survey's images, named by what is small, so that any process that sees the files can read them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from shirube_bags.bag_reader import BagReader
from shirube_geometry import PinholeCamera
from shirube_ros.file_errors import ImageFileError
from shirube_ros.image_conversion import array_from_compressed_image, array_from_image
from shirube_ros.image_files import load_image
from shirube_ros.message_error import MessageError

Pixels = NDArray[np.uint8]


class ImagePart(Protocol):
    """Images in their order."""

    def __iter__(self) -> Iterator[tuple[int, Pixels | str]]:
        """Yield index and pixels of each, or what is wrong with it in a line."""
        ...


@dataclass(frozen=True)
class FilePart:
    """Image files.

    Attributes:
        files: each with its index in the survey.
        camera: that took them.
    """

    files: tuple[tuple[int, Path], ...]
    camera: PinholeCamera

    def __iter__(self) -> Iterator[tuple[int, Pixels | str]]:
        """Yield index and pixels of each, or what is wrong with it in a line."""
        for index, path in self.files:
            try:
                yield index, _sized(load_image(path), self.camera, str(path))
            except ImageFileError as fault:
                yield index, str(fault)


@dataclass(frozen=True)
class BagPart:
    """Images of a stretch of a bag.

    Attributes:
        path: of the bag.
        topic: of the images.
        begin_ns: when the first one was received; the part of the bag before is not read [ns].
        end_ns: when the last one was received [ns].
        first: index in the survey of the first image on the topic that was received then.
        wanted: indices of the images that are read.
        camera: that took them.
    """

    path: Path
    topic: str
    begin_ns: int
    end_ns: int
    first: int
    wanted: tuple[int, ...]
    camera: PinholeCamera

    def __iter__(self) -> Iterator[tuple[int, Pixels | str]]:
        """Yield index and pixels of each, or what is wrong with it in a line."""
        wanted = set(self.wanted)
        with BagReader(self.path) as bag:
            stretch = bag.messages_between([self.topic], self.begin_ns, self.end_ns)
            for index, raw in enumerate(stretch, start=self.first):
                if index in wanted:
                    yield (
                        index,
                        self._pixels(bag.decode(raw), is_compressed=raw.msgtype.endswith('CompressedImage')),
                    )

    def _pixels(self, message: Any, *, is_compressed: bool) -> Pixels | str:
        read = array_from_compressed_image if is_compressed else array_from_image
        try:
            return _sized(read(message, self.topic), self.camera, self.topic)
        except MessageError as fault:
            return str(fault)


def _sized(pixels: Pixels, camera: PinholeCamera, name: str) -> Pixels | str:
    height, width = pixels.shape[:2]
    if (width, height) == (camera.width, camera.height):
        return pixels
    return (
        f'{name}: is {width} x {height} px, the calibration is for {camera.width} x {camera.height} px; '
        'survey with images of one size'
    )
