"""Locate the pages of photographs among all pages, and compare with where their frames say that they are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from card_outlines import frame_of
from frame_finder import FoundFrame
from numpy.typing import NDArray
from page_identification import PagePose, transform_points
from page_truth import Photograph, framed_page
from page_views import VIEW_CAMERA, VIEW_MOUNT, page_map, page_origin, page_view, random_view_pose

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from shirube_core.geometry import SE2

Array = NDArray[np.float64]

AGREEMENT = 0.0005  # of a right pose with the frame's, at the page's centre [m]
ELSEWHERE = 0.005  # beyond which a pose is another place [m]


@dataclass(frozen=True)
class PageTrial:
    """One found frame, located without a prior.

    Attributes:
        number: index of the photograph.
        page: the true page, None for a frame that is none.
        outcome: ``right``, ``off`` (the right page, but beyond the agreement), ``none`` or ``wrong``.
        without_it: the outcome with the page left out of the map: ``none`` or ``wrong``.
        reason: why there is no pose, empty where there is one.
        error: distance of the page's centre from where the frame has it [m], NaN without a pose.
        error_from_dots: and from where the oracle's homography of the dots has it [m].
        turn: error of the heading [rad].
    """

    number: int
    page: int | None
    outcome: str
    without_it: str
    reason: str = ''
    error: float = np.nan
    error_from_dots: float = np.nan
    turn: float = np.nan


class PageBench:
    """The map of all pages, ready to locate views in it."""

    def __init__(self, pages: list[Array]) -> None:
        self._pages = pages
        self._localizers: dict[int | None, FloorLocalizer] = {}

    def trials(self, photograph: Photograph, generator: np.random.Generator) -> Iterator[PageTrial]:
        """Yield a trial for each frame that was found in a photograph."""
        for frame in photograph.frames:
            yield self._trial(photograph, frame, random_view_pose(generator))

    def _trial(self, photograph: Photograph, frame: FoundFrame, T_page_base: SE2) -> PageTrial:
        page, corners = framed_page(photograph, frame) or (None, frame.corners)
        outline = frame_of(page, is_printed=frame.is_printed)
        view = page_view(photograph.image, corners, outline, T_page_base)
        dots = self._localizer(None).detect(view)
        fix = self._localizer(None).locate_dots(dots, VIEW_CAMERA)
        without = self._localizer(page).locate_dots(dots, VIEW_CAMERA)
        without_it = 'wrong' if isinstance(without, Fix) else 'none'
        if not isinstance(fix, Fix):
            reason = f'{fix.reason.value}: {fix.detail}'
            return PageTrial(photograph.number, page, 'none', without_it, reason)
        if page is None:
            return PageTrial(photograph.number, None, 'wrong', without_it)
        off = _offset(fix, T_page_base, page)
        error = float(np.linalg.norm(off))
        from_dots = off - _centre_by_dots(photograph.pages[page], corners, outline)
        outcome = 'right' if error <= AGREEMENT else 'off' if error <= ELSEWHERE else 'wrong'
        turn = T_page_base.yaw_to(fix.T_map_base)
        to_dots = float(np.linalg.norm(from_dots))
        return PageTrial(photograph.number, page, outcome, without_it, '', error, to_dots, turn)

    def _localizer(self, left_out: int | None) -> FloorLocalizer:
        if left_out not in self._localizers:
            floor = index_map(page_map(self._pages, left_out))
            self._localizers[left_out] = FloorLocalizer(floor, VIEW_MOUNT)
        return self._localizers[left_out]


def _offset(fix: Fix, T_page_base: SE2, page: int) -> Array:
    """Return where a fix has the middle of the frame, relative to the page's centre [m]."""
    middle = T_page_base.inverse().transform(np.zeros((1, 2)))
    return fix.T_map_base.transform(middle)[0] - page_origin(page)


def _centre_by_dots(pose: PagePose, corners: Array, outline: Array) -> Array:
    """Return where the page's dots have the point that is the page's centre by its frame [m]."""
    homography = cv2.getPerspectiveTransform(outline.astype(np.float32), corners.astype(np.float32))
    by_frame = transform_points(homography.astype(np.float64), np.zeros((1, 2)))
    return transform_points(np.linalg.inv(pose.homography), by_frame)[0]
