"""Batches of a survey's images: small references that any process with access to the files can read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import PinholeCamera
from shirube_ros.camera.files import load_image
from shirube_ros.camera.image import array_from_compressed_image, array_from_image
from shirube_ros.errors import ImageFileError, MessageError

Pixels = NDArray[np.uint8]


class ImageBatch(Protocol):
    """Images in order."""

    def __iter__(self) -> Iterator[tuple[int, Pixels | str]]:
        """Yield index and pixels of each image, or a one-line error message instead of the pixels."""
        ...


@dataclass(frozen=True)
class FileImageBatch:
    """Image files.

    Attributes:
        files: index in the survey and path of each image.
        camera: camera that took the images.
    """

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
                    yield (
                        index,
                        self._pixels(bag.decode(raw), is_compressed=raw.msgtype.endswith('CompressedImage')),
                    )

    def _pixels(self, message: Any, *, is_compressed: bool) -> Pixels | str:
        read = array_from_compressed_image if is_compressed else array_from_image
        try:
            return _check_size(read(message, self.topic), self.camera, self.topic)
        except MessageError as fault:
            return str(fault)


def _check_size(pixels: Pixels, camera: PinholeCamera, name: str) -> Pixels | str:
    height, width = pixels.shape[:2]
    if (width, height) == (camera.width, camera.height):
        return pixels
    return (
        f'{name}: is {width} x {height} px, the calibration is for {camera.width} x {camera.height} px; '
        'survey with images of one size'
    )
