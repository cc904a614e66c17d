"""Where each page is in a row of images, by its dots alone: the truth that the frame finder is measured with."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from page_identification import FINE, PagePose, fit_page, transform_points
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

LENGTH_ERROR = 0.06  # of a dot pair on a neighbour's plane, relative
PAIR = (0.02, 0.06)  # length of the dot pairs tried [m]
NEAR = 0.003  # of a match behind a pair's motion [m]
ENOUGH = 17  # dots of a page that no other page has in the same place
TRIES = 12  # dot pairs a page is searched with


def track_page(pose: PagePose, page: Array, before: Image, after: Image, dots: Array) -> PagePose | None:
    """Return the pose in the next image of a page with the pose known in the one before, None where it is lost."""
    known = transform_points(pose.homography, page).astype(np.float32).reshape(-1, 1, 2)
    moved, status, _ = cv2.calcOpticalFlowPyrLK(before, after, known, None, winSize=(31, 31), maxLevel=4)
    good = status[:, 0] == 1
    if good.sum() < 8:
        return None
    guess, _ = cv2.findHomography(page[good], moved[good, 0].astype(np.float64), cv2.RANSAC, 2.0)
    if guess is None:
        return None
    return fit_page(pose.page, page, guess, dots)


def find_nearby_page(
    known: dict[int, PagePose], pages: list[Array], dots: Array, generator: np.random.Generator
) -> dict[int, PagePose]:
    """Return further pages in an image, that lie about in the plane of one that is known.

    The known page's homography makes the plane metric, so that pairs of dots give a page's motion in it.
    """
    found: dict[int, PagePose] = {}
    for plane in known.values():
        others = {**known, **found}
        taken = [transform_points(pose.homography, pages[index]) for index, pose in others.items()]
        gap = np.linalg.norm(dots[:, None] - np.concatenate(taken)[None], axis=2).min(axis=1)
        free = dots[gap > 3.0]
        on_plane = transform_points(np.linalg.inv(plane.homography), free)
        nearby = np.linalg.norm(on_plane, axis=1) < 0.3
        for index, page in enumerate(pages):
            if index in others:
                continue
            motion = _motion_of(page, on_plane[nearby], generator)
            if motion is None:
                continue
            pose = fit_page(index, page, plane.homography @ motion, free)
            if pose is not None and pose.matches >= ENOUGH and pose.residual < FINE / 2.0:
                found[index] = pose
    return found


def _motion_of(page: Array, points: Array, generator: np.random.Generator) -> Array | None:
    """Return the rigid motion, shape (3, 3), that brings most of a page's dots onto points, None below 10."""
    if len(points) < ENOUGH:
        return None
    tree = cKDTree(points)
    places, marks = points @ (1.0, 1j), page @ (1.0, 1j)
    leg = places[None] - places[:, None]
    length = np.abs(leg)
    usable = np.argwhere((length > PAIR[0]) & (length < PAIR[1]))
    page_leg = marks[None] - marks[:, None]
    best, chosen = 9, None
    for first, second in generator.permutation(usable)[: TRIES * len(points) // ENOUGH]:
        ratio = np.abs(page_leg) / length[first, second]
        i, j = np.nonzero(np.abs(ratio - 1.0) < LENGTH_ERROR)
        if len(i) == 0:
            continue
        turn = leg[first, second] / page_leg[i, j]
        turn /= np.abs(turn)
        shift = places[first] - turn * marks[i]
        moved = (turn[:, None] * marks + shift[:, None]).ravel()
        distance, _ = tree.query(np.column_stack([moved.real, moved.imag]), distance_upper_bound=NEAR)
        counts = np.isfinite(distance).reshape(len(i), -1).sum(axis=1)
        k = int(counts.argmax())
        if counts[k] > best:
            best = int(counts[k])
            c, d, x, y = turn[k].real, turn[k].imag, shift[k].real, shift[k].imag
            chosen = np.array([[c, -d, x], [d, c, y], [0.0, 0.0, 1.0]])
    return chosen
