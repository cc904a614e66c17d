"""Blooming model of a lamp, eq. (4) of the paper with its bracket corrected, and the true radius.

At the distance d from the centre the brightness is b within the radius p and beyond it
``(b - gamma) (1 - s(alpha (d - p - beta))) + gamma`` with the logistic function s. One image determines only p + beta,
the half-maximum radius; images at known distances, where p is known, separate the two. At run time `fit_lit_lamp` fits
b, alpha, gamma and p + beta to each lamp, whatever the exposure; beta, a property of the lens, is the calibrated one.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.special import expit

from vlc_beacon.core.lamp_image.lamp_tracker import LampSample
from vlc_beacon.core.vlc_beacon_error import LampImageError

BIN_WIDTH = 0.25
"""Width of the annuli over which brightness is averaged [px]."""
PROFILE_RADII, PROFILE_MARGIN = 1.2, 6.0
"""Radius of the fitted profile, in radii and a margin [px]: farther out the glow fades, unlike that of eq. (4)."""
EDGE_RINGS = 4
"""Annuli over which the steepest fall of the profile is searched."""
RADIUS_MIN = 1.0
WHITE = 255.0
"""Level at which pixels are clipped [grey levels]."""
PRIOR_WEIGHT = 4.0
"""Weight of the initial log brightness, which overexposure leaves almost undetermined [grey levels]."""
LIT_COSINE = 0.5
"""Cosine of half the angle of the sector that is fitted of a lamp with one lit half: away from the split."""
LIT_MIN = 0.7
"""Minimum brightness of a half that is fitted at run time."""
FIT_RADIUS_MIN, FIT_RESIDUAL_MAX = 4.0, 0.05
"""Minimum radius [px] and maximum RMS residual over b - gamma of a lamp that eq. (4) describes at run time."""


@dataclass(frozen=True)
class BloomingFit:
    """Radial brightness profile of one lamp.

    Attributes:
        alpha: steepness of the rim [1/px].
        half_maximum_radius: p + beta, the half-maximum radius [px].
        gamma: brightness of the background [grey levels].
        brightness: b, brightness of the lamp, above `WHITE` if it is overexposed [grey levels].
        residual: RMS residual over b - gamma.
    """

    alpha: float
    half_maximum_radius: float
    gamma: float
    brightness: float
    residual: float


@dataclass(frozen=True)
class BloomingCalibration:
    """Blooming of one lamp type in one camera.

    Attributes:
        alpha: steepness of the rim [1/px].
        beta: increase of the apparent lamp radius [px].
        gamma: brightness of the background [grey levels].
        beta_sigma: standard deviation of beta [px]; infinite for one image.
    """

    alpha: float
    beta: float
    gamma: float
    beta_sigma: float


def fit_lit_lamp(image: NDArray[np.uint8], sample: LampSample) -> BloomingFit | None:
    """Fit eq. (4) to a tracked lamp; None if it is too small or dark, cut off, or if eq. (4) does not describe it.

    Of a split lamp whose other half is dark only the lit half is used.
    """
    if not sample.is_lit or sample.radius < FIT_RADIUS_MIN or sample.half_brightness.max() < LIT_MIN:
        return None
    direction, (first, second) = None, sample.half_brightness.tolist()
    if sample.split_axis is not None and min(first, second) < LIT_MIN:
        direction = sample.split_axis if first > second else -sample.split_axis
    try:
        fit = fit_blooming(image, sample.centre, sample.radius, direction)
    except LampImageError:
        return None
    return fit if fit.residual < FIT_RESIDUAL_MAX and fit.half_maximum_radius > RADIUS_MIN else None


def fit_blooming(
    image: NDArray[np.uint8], centre: NDArray[np.float64], radius: float, direction: NDArray[np.float64] | None = None
) -> BloomingFit:
    """Fit eq. (4) to a lamp.

    Args:
        image: grey image, shape (h, w).
        centre: centre of the lamp, shape (2,) [px].
        radius: initial half-maximum radius [px].
        direction: unit vector from the centre to the lit half, shape (2,), None for a lamp that is lit all over.

    Raises:
        LampImageError: the lamp is cut off by the image border, or there is no lamp.
    """
    distances, levels, weights = _radial_profile(image, centre, PROFILE_RADII * radius + PROFILE_MARGIN, direction)
    # The threshold that gave the initial radius may be at the glow of an overexposed lamp: begin at the steepest fall.
    falls = levels[:-EDGE_RINGS] - levels[EDGE_RINGS:]
    edge = float(distances[EDGE_RINGS // 2 + int(falls.argmax())])
    count = int(np.searchsorted(distances, PROFILE_RADII * edge + PROFILE_MARGIN))
    distances, levels, weights = distances[:count], levels[:count], weights[:count]
    brightest, darkest = float(levels[distances < max(0.7 * edge, 1.0)].mean()), float(levels[-4:].mean())
    if not brightest > darkest:
        raise LampImageError(f'no lamp at ({centre[0]:.0f}, {centre[1]:.0f}); give the centre of a bright spot')
    start = np.array([math.log(brightest - darkest), darkest, edge, 0.5])

    # Eq. (4) beyond the rim, with its bracket corrected; within it the sigmoid is almost zero. Pixels are clipped.
    def residuals(guess: NDArray[np.float64]) -> NDArray[np.float64]:
        log_rise, gamma, half, log_alpha = guess
        sigmoid = expit(np.exp(log_alpha) * (distances - half))
        brightness = np.exp(log_rise) * (1.0 - sigmoid) + gamma
        misfit = weights * (np.minimum(brightness, WHITE) - levels)
        return np.append(misfit, PRIOR_WEIGHT * (log_rise - start[0]))

    solved = least_squares(residuals, start, method='lm', max_nfev=300)
    log_rise, gamma, half, log_alpha = (float(value) for value in solved.x)
    rise = math.exp(log_rise)
    residual = math.sqrt(2.0 * solved.cost / float(weights @ weights)) / rise
    return BloomingFit(math.exp(log_alpha), half, gamma, rise + gamma, residual)


def calibrate_blooming(
    fits: Sequence[BloomingFit], depths: Sequence[float], lamp_radius: float, focal_length: float
) -> BloomingCalibration:
    """Separate p from beta with images of a lamp at known depths.

    Args:
        fits: profiles of one lamp or of several equal lamps.
        depths: depth of the lamp along the optical axis in each image [m].
        lamp_radius: true lamp radius [m].
        focal_length: focal length [px].

    Raises:
        LampImageError: no fits, a different number of depths, or sizes that are not positive.
    """
    if len(fits) == 0 or len(fits) != len(depths):
        raise LampImageError(f'{len(fits)} lamps and {len(depths)} depths; give one depth for each lamp')
    if not (min(depths) > 0.0 and lamp_radius > 0.0 and focal_length > 0.0):
        raise LampImageError('a depth, the radius or the focal length is not positive; give metres and pixels')
    true_radii = lamp_radius * focal_length / np.asarray(depths, dtype=np.float64)
    betas = np.array([fit.half_maximum_radius for fit in fits]) - true_radii
    standard_error = float(np.std(betas, ddof=1) / math.sqrt(len(betas))) if len(betas) > 1 else math.inf
    return BloomingCalibration(
        float(np.median([fit.alpha for fit in fits])),
        float(np.mean(betas)),
        float(np.median([fit.gamma for fit in fits])),
        standard_error,
    )


def _radial_profile(
    image: NDArray[np.uint8], centre: NDArray[np.float64], profile_radius: float, direction: NDArray[np.float64] | None
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return distances [px], mean brightness and square roots of pixel counts of annuli, each of shape (n,)."""
    left, top = (int(low) for low in np.floor(centre - profile_radius))
    right, bottom = (int(high) + 1 for high in np.ceil(centre + profile_radius))
    is_inside = left >= 0 and top >= 0 and right <= image.shape[1] and bottom <= image.shape[0]
    if not is_inside or profile_radius < RADIUS_MIN:
        raise LampImageError(
            f'the lamp at ({centre[0]:.0f}, {centre[1]:.0f}) is cut off by the border; choose another image'
        )
    v, u = np.mgrid[top:bottom, left:right]
    distance = np.hypot(u - centre[0], v - centre[1])
    ring = (distance / BIN_WIDTH).astype(np.int64).ravel()
    inside = ring < int(profile_radius / BIN_WIDTH)
    if direction is not None:
        along = (u - centre[0]) * direction[0] + (v - centre[1]) * direction[1]
        inside &= (along > LIT_COSINE * distance).ravel()
    values = image[top:bottom, left:right].astype(np.float64).ravel()[inside]
    counts = np.bincount(ring[inside])
    filled = counts > 0
    means = np.bincount(ring[inside], values)[filled] / counts[filled]
    distances = np.bincount(ring[inside], distance.ravel()[inside])[filled] / counts[filled]
    return distances, means, np.sqrt(counts[filled])
