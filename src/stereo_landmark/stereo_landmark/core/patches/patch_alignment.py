"""Where an image shows a taught patch: Gauss-Newton on grey values (Lucas & Kanade 1981).

The inverse compositional form of Baker & Matthews (2004): the derivatives are those of the taught patch, so that they
are known beforehand. Gain, offset, blur and an even change of gain across the patch are fitted along, Tukey's weights
leave out what is not as it was taught.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.patches.patch_template import MOTIONS, PatchTemplate, motion_fields
from stereo_landmark.core.patches.smoothing import NOISE, coefficients_of
from stereo_landmark.core.symmetric_matrix import invert_symmetric

ROUNDS = 6
STEP_DONE = 0.01
"""A step that moves the patch by less was the last one [px]."""
STEP_MAX = 1.5
"""A patch that moves farther at once is not where it was looked for [px]."""
TUKEY = 4.7
SCALE = 1.4826
SCALE_SAMPLES = 7
"""The scatter is told by every seventh pixel."""
SCALE_MIN = 0.05
"""Smoothed grey values are not nearer to each other than this."""
AGREEING_MIN = 0.7
"""Part of the pixels that must be as they were taught."""
LIKENESS_MIN = 0.9
"""Part of the variance of these pixels that the taught patch must explain."""
GAINS = 0.2, 5.0
SLACK = 5
"""The patch is looked for so far around where it should be [px]."""
MODEL_SIGMA = 0.004
"""What differs between images of one plane besides noise moves a point by so much [px]."""
GAIN = MOTIONS


@dataclass(frozen=True)
class AlignedPatch:
    """A patch in another image.

    Attributes:
        points: of the patch, shape (4, 2) [px].
        covariance: of their coordinates, by the noise of this image, shape (8, 8) [px²].
        taught_covariance: the same for the taught image, in its pixels.
        corners: of the patch, shape (4, 2) [px].
    """

    points: NDArray[np.float64]
    covariance: NDArray[np.float64]
    taught_covariance: NDArray[np.float64]
    corners: NDArray[np.float64]


def align_patch(
    template: PatchTemplate, image: NDArray[np.uint8], start: NDArray[np.float64]
) -> AlignedPatch | None:
    """Find a patch.

    Args:
        template: as taught.
        image: shape (h, w), grey.
        start: where its corners should be, about a pixel off at most, shape (4, 2) [px].

    Returns:
        None where the image does not show it there, or something else in a large part of it.
    """
    low = np.maximum(np.floor(start.min(axis=0)).astype(int) - SLACK - 3, 0)
    high = np.ceil(start.max(axis=0)).astype(int) + SLACK + 4
    part = image[low[1] : high[1], low[0] : high[0]]
    if min(part.shape) < 3 * SLACK:
        return None
    homography = cv2.getPerspectiveTransform(
        template.corners.astype(np.float32), (start - low).astype(np.float32)
    )
    inverse = template.inverse.copy()
    scale = float(template.half.max())
    rest, gain = _aligned(
        coefficients_of(part), template.places, template.columns, scale, homography, inverse
    )
    if not rest >= 0.0:
        return None
    return _measured(template, homography, low, inverse[:MOTIONS, :MOTIONS] / gain**2, rest)


def _measured(
    template: PatchTemplate,
    homography: NDArray[np.float64],
    low: NDArray[np.int64],
    inverse: NDArray[np.float64],
    rest: float,
) -> AlignedPatch:
    """Return the points with what the noise, half of it in either image, makes of them."""
    pixels, jacobians = _projected(homography, template.points)
    fields = motion_fields(template.points)
    (_, (middle,)) = _projected(homography, np.zeros((1, 2)))
    growth = abs(float(np.linalg.det(middle))) / float(np.prod(template.half))
    noise = 0.5 * rest / NOISE * template.correlation
    here = (jacobians @ fields).reshape(MOTIONS, MOTIONS)
    taught = (template.half[:, None] * fields).reshape(MOTIONS, MOTIONS)
    model = MODEL_SIGMA**2 * np.eye(MOTIONS)
    return AlignedPatch(
        pixels + low,
        noise / growth * here @ inverse @ here.T + model,
        noise * taught @ inverse @ taught.T + model,
        _projected(homography, template.corners)[0] + low,
    )


def _projected(
    homography: NDArray[np.float64], places: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where places are seen, shape (n, 2), and the derivatives by the places, shape (n, 2, 2)."""
    projected = places @ homography[:, :2].T + homography[:, 2]
    pixels = projected[:, :2] / projected[:, 2:]
    by_places = homography[None, :2, :2] - pixels[:, :, None] * homography[None, 2:, :2]
    return pixels, by_places / projected[:, 2, None, None]


@njit(cache=True, error_model='numpy')
def _aligned(
    image: NDArray[np.float32],
    places: NDArray[np.float64],
    columns: NDArray[np.float64],
    scale: float,
    homography: NDArray[np.float64],
    inverse: NDArray[np.float64],
) -> tuple[float, float]:
    """Move the homography to where the image shows the patch, and write the inverse with the weights it found.

    Returns:
        the mean square of what is left, -1 where the patch is not there, and the gain.
    """
    n = len(places)
    values, weights, rests = np.empty(n), np.ones(n), np.empty(n)
    solution, step = np.zeros(columns.shape[1]), np.inf
    for k in range(ROUNDS):
        if not _write_values(image, places, homography, values):
            return -1.0, 0.0
        # What moved within the patch draws it along until the weights leave it out.
        if k > 0:
            _write_rests(columns, values, solution, rests)
            _write_weights(rests, weights)
            if not _invert_normal(columns, weights, inverse):
                return -1.0, 0.0
        _write_solution(columns, values, weights, inverse, solution)
        if not GAINS[0] < solution[GAIN] < GAINS[1]:
            return -1.0, 0.0
        step = _move(homography, solution, scale)
        if step > STEP_MAX:
            return -1.0, 0.0
        if k > 0 and step < STEP_DONE:
            break
    if step > 5.0 * STEP_DONE:
        return -1.0, 0.0
    _write_rests(columns, values, solution, rests)
    return _judged(values, weights, rests, len(solution)), solution[GAIN]


@njit(cache=True, error_model='numpy')
def _write_values(
    image: NDArray[np.float32],
    places: NDArray[np.float64],
    homography: NDArray[np.float64],
    values: NDArray[np.float64],
) -> bool:
    """Write what the image shows at places; False where one lies outside."""
    height, width = image.shape
    h = homography
    for n in range(len(places)):
        s, t = places[n, 0], places[n, 1]
        w = 1.0 / (h[2, 0] * s + h[2, 1] * t + h[2, 2])
        x = (h[0, 0] * s + h[0, 1] * t + h[0, 2]) * w
        y = (h[1, 0] * s + h[1, 1] * t + h[1, 2]) * w
        if not (1.0 <= x < width - 2.0 and 1.0 <= y < height - 2.0):
            return False
        i, j = int(x) - 1, int(y) - 1
        across, down = _spline(np.float32(x - i - 1)), _spline(np.float32(y - j - 1))
        total = np.float32(0.0)
        for r in range(4):
            four = image[j + r, i : i + 4]
            row = across[0] * four[0] + across[1] * four[1] + across[2] * four[2] + across[3] * four[3]
            total += down[r] * row
        values[n] = total
    return True


@njit(cache=True, error_model='numpy')
def _spline(f: np.float32) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    """Return the cubic spline's weights of the four pixels around a part of a pixel."""
    sixth, half, g = np.float32(1.0 / 6.0), np.float32(0.5), np.float32(1.0) - f
    inner = np.float32(2.0 / 3.0)
    return (
        g * g * g * sixth,
        inner - f * f * (np.float32(1.0) - half * f),
        inner - g * g * (np.float32(1.0) - half * g),
        f * f * f * sixth,
    )


@njit(cache=True, error_model='numpy')
def _write_rests(
    columns: NDArray[np.float64],
    values: NDArray[np.float64],
    solution: NDArray[np.float64],
    rests: NDArray[np.float64],
) -> None:
    """Write what the patch, with gain, offset and blur but where it is, does not explain."""
    for n in range(len(values)):
        rests[n] = values[n]
        for c in range(MOTIONS, columns.shape[1]):
            rests[n] -= columns[n, c] * solution[c]


@njit(cache=True, error_model='numpy')
def _write_weights(rests: NDArray[np.float64], weights: NDArray[np.float64]) -> None:
    limit = TUKEY * max(SCALE * np.median(np.abs(rests[::SCALE_SAMPLES])), SCALE_MIN)
    for n in range(len(rests)):
        z = rests[n] / limit
        weights[n] = (1.0 - z * z) ** 2 if abs(z) < 1.0 else 0.0


@njit(cache=True, error_model='numpy')
def _invert_normal(
    columns: NDArray[np.float64], weights: NDArray[np.float64], inverse: NDArray[np.float64]
) -> bool:
    """Write the inverse of the weighted normal matrix; False where it is singular."""
    count = columns.shape[1]
    normal, row = np.zeros((count, count)), np.empty(count)
    for n in range(len(weights)):
        if weights[n] == 0.0:
            continue
        for c in range(count):
            row[c] = columns[n, c]
        for r in range(count):
            weighed = weights[n] * row[r]
            for c in range(r + 1):
                normal[r, c] += weighed * row[c]
    for r in range(count):
        for c in range(r):
            normal[c, r] = normal[r, c]
    return bool(invert_symmetric(normal, inverse))


@njit(cache=True, error_model='numpy')
def _write_solution(
    columns: NDArray[np.float64],
    values: NDArray[np.float64],
    weights: NDArray[np.float64],
    inverse: NDArray[np.float64],
    solution: NDArray[np.float64],
) -> None:
    """Write the weighted least squares solution."""
    count = columns.shape[1]
    pull = np.zeros(count)
    for n in range(len(values)):
        weighed = weights[n] * values[n]
        for c in range(count):
            pull[c] += weighed * columns[n, c]
    for r in range(count):
        solution[r] = 0.0
        for c in range(count):
            solution[r] += inverse[r, c] * pull[c]


@njit(cache=True, error_model='numpy')
def _move(homography: NDArray[np.float64], solution: NDArray[np.float64], scale: float) -> float:
    """Apply a solution's motion to the homography; return how far it moves the patch at most, roughly [px]."""
    m = solution[:MOTIONS] / solution[GAIN]
    motion = np.array([[1.0 + m[1], m[2], m[0]], [m[4], 1.0 + m[5], m[3]], [-m[6], -m[7], 1.0]])
    moved = homography @ np.linalg.inv(motion)
    homography[:] = moved / moved[2, 2]
    return scale * np.max(np.abs(m))


@njit(cache=True, error_model='numpy')
def _judged(
    values: NDArray[np.float64], weights: NDArray[np.float64], rests: NDArray[np.float64], unknowns: int
) -> float:
    """Return the mean square of what is left of the agreeing pixels, -1 where they are too few or too unlike."""
    total, mean, squares, left, agreeing = 0.0, 0.0, 0.0, 0.0, 0
    for n in range(len(values)):
        if weights[n] > 0.0:
            total += weights[n]
            mean += weights[n] * values[n]
            agreeing += 1
    mean /= max(total, 1e-9)
    for n in range(len(values)):
        if weights[n] > 0.0:
            squares += weights[n] * (values[n] - mean) ** 2
            left += rests[n] ** 2
    left /= max(agreeing - unknowns, 1)
    if agreeing < AGREEING_MIN * len(values) or left > (1.0 - LIKENESS_MIN) * squares / total:
        return -1.0
    return left
