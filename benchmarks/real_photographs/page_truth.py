"""What is to be found in each photograph: the pages, where they are, and which of them are visible."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from card_outlines import CARD_OUTLINES, frame_of
from corner_visibility import visible_corners
from frame_finder import FoundFrame, find_frames
from numpy.typing import NDArray
from page_dots import find_page_dots
from page_identification import PagePose, identify_page, transform_points
from page_tracking import find_nearby_page, track_page

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

LEAST_DOTS = 15  # seen of a visible page
LEAST_TRACKED = 10  # dots of a page that is followed from image to image
GREATEST_RESIDUAL = 0.0005  # of the dots of a page that is followed [m]
SEARCH_EVERY = 98  # images between two searches for pages whose frame was not found
SAME_FRAME = 0.003  # of a found corner from the true one [m]


@dataclass(frozen=True)
class Photograph:
    """An image with the frames found in it and the truth about its pages.

    Attributes:
        number: index of the movie's frame.
        image: grey, undistorted.
        frames: what the frame finder found.
        identities: the page in each of these frames as the oracle sees it, None where it sees none.
        dots: shape (n, 2), the dots that the benchmark's own finder sees [px].
        pages: the pages whose dots are in the image, by index.
    """

    number: int
    image: Image
    frames: list[FoundFrame]
    identities: list[PagePose | None]
    dots: Array
    pages: dict[int, PagePose]


def detect_pages(number: int, image: Image, camera_matrix: Array, pages: list[Array]) -> Photograph:
    """Find the frames in an image and which pages they are, by the oracle."""
    dots = find_page_dots(image)
    frames = find_frames(image, camera_matrix)
    identities = [
        identify_page(frame.corners, frame_of(None, is_printed=frame.is_printed), dots, pages)
        for frame in frames
    ]
    known = {pose.page: pose for pose in identities if pose is not None}
    return Photograph(number, image, frames, identities, dots, known)


def detect_all_pages(
    images: Iterable[tuple[int, Image]], camera_matrix: Array, pages: list[Array]
) -> list[Photograph]:
    """Find the frames in a row of images, and all pages by their dots, followed forwards and backwards."""
    generator = np.random.default_rng(1)
    photographs = []
    for count, (number, image) in enumerate(images):
        photograph = detect_pages(number, image, camera_matrix, pages)
        if count % SEARCH_EVERY == 0:
            photograph.pages.update(find_nearby_page(photograph.pages, pages, photograph.dots, generator))
        photographs.append(photograph)
    _follow(photographs, pages)
    return photographs


def _follow(photographs: list[Photograph], pages: list[Array]) -> None:
    """Take pages from image to image, forwards and then backwards."""
    for order in (range(1, len(photographs)), range(len(photographs) - 2, -1, -1)):
        for k in order:
            before, after = photographs[k - order.step], photographs[k]
            for index, pose in before.pages.items():
                if index not in after.pages:
                    moved = track_page(pose, pages[index], before.image, after.image, after.dots)
                    if (
                        moved is not None
                        and moved.matches >= LEAST_TRACKED
                        and moved.residual < GREATEST_RESIDUAL
                    ):
                        after.pages[index] = moved


def visible_pages(photograph: Photograph, *, is_printed: bool) -> set[int]:
    """Return the pages with all four corners of the frame seen and at least 15 dots uncovered.

    The corners are looked for where the page's dots say that they are. A card whose outline was never seen whole
    (number 2, which is partly under another one) is not visible.
    """
    return {
        index
        for index, pose in photograph.pages.items()
        if pose.matches >= LEAST_DOTS
        and (is_printed or index in CARD_OUTLINES)
        and visible_corners(
            photograph.image, pose.homography, frame_of(index, is_printed=is_printed), is_printed=is_printed
        ).all()
    }


def framed_page(photograph: Photograph, frame: FoundFrame) -> tuple[int, Array] | None:
    """Return the page whose frame was found, and the corners from its upper left one on; None for a false frame."""
    for index, pose in photograph.pages.items():
        on_page = transform_points(np.linalg.inv(pose.homography), frame.corners)
        outline = frame_of(index, is_printed=frame.is_printed)
        for turn in range(4):
            if np.abs(np.roll(on_page, -turn, axis=0) - outline).max() < SAME_FRAME:
                return index, np.roll(frame.corners, -turn, axis=0)
    return None
