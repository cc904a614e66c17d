"""Height, tilt and pixel scale of the belly camera from one image of a mat.

Its dots are matched without knowing height and tilt. The scale is the printed diameter of the dots over their diameter
in the image. The image is rectified for a grid of tilts around the initial one; for the right tilt its dots match the
mat by a similarity.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.dots import DetectedDots, DotMap
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.mat.mount_fit import KnownHeight, MountFit, fit_mount
from floor_localizer.core.survey.dot_matching import DotMatch, DotMatcher, MatchTolerances
from shirube_core.geometry import SE2, CameraMount, PinholeCamera, matrix_from_rpy, wrap_angle

# Tilts to try about both axes [rad]; the error from tilts in between is smaller than the dot spacing.
_TILTS = tuple(math.radians(degrees) for degrees in (0.0, -5.0, 5.0, -10.0, 10.0, -15.0, 15.0))
_SCALE_TOLERANCE = 0.12  # relative error of the scale estimated from dot diameters, as ink spreads and edges blur
_SIGMA = 0.0004
_CHANCE_ALIGNMENTS_MAX = 1e-6
_STOP_FRACTION = 0.8  # fraction of matched dots at which the search over tilts stops
_MIN_DOTS = 12
_MIN_COVERAGE = 0.4  # smallest fraction of the image's width and height covered by the matched dots
_RESIDUAL_MAX = 1.5
_SIGMA_TILT_MAX, _SIGMA_HEIGHT_MAX, _SIGMA_FOCAL_MAX = math.radians(0.3), 0.02, 0.03


def match_mat(
    dots: DetectedDots, camera: PinholeCamera, mat: DotMap, initial_mount: CameraMount
) -> tuple[Ints, Ints] | None:
    """Return the matched dots in image and mat (indices); None if none match within 15 degrees of the initial mount."""
    matcher = DotMatcher(mat.points)
    height = float(np.median(mat.diameters)) * math.sqrt(camera.fx * camera.fy) / float(np.median(dots.diameters))
    rays = camera.rays_from_pixels(dots.pixels)
    valid = np.flatnonzero(np.isfinite(rays).all(axis=1))  # others are beyond the range of the lens model
    rays = rays[valid]
    tolerances = MatchTolerances(_SIGMA, _SCALE_TOLERANCE, math.radians(2.5) / height, _CHANCE_ALIGNMENTS_MAX)
    best: DotMatch | None = None
    for roll, pitch in sorted(itertools.product(_TILTS, _TILTS), key=lambda tilt: math.hypot(*tilt)):
        rotation = matrix_from_rpy((roll, pitch, 0.0)) @ initial_mount.rotation
        directions = rays @ rotation.T
        if (directions[:, 2] > -0.2).any():
            continue
        points = -height * directions[:, :2] / directions[:, 2:]
        found = matcher.match_anywhere(points - points.mean(axis=0), tolerances)
        if found is not None and (best is None or len(found.source) > len(best.source)):
            best = found
            if len(found.source) > _STOP_FRACTION * len(valid):
                break
    return None if best is None else (valid[best.source], best.target)


@dataclass(frozen=True)
class CameraCalibration:
    """Calibrated mount of the camera.

    Attributes:
        mount: pose of the camera in the base frame.
        fit: fit of the camera over the mat.
        tilt: angle between the optical axis and straight down [rad].
        sigma_tilt: standard deviation of the tilt about its worst axis [rad].
        sigma_height: standard deviation of the height [m].
        pixel: size of a pixel on the floor below the camera [m].
        sigma_pixel: standard deviation of the pixel size [m].
        sigma_focal: relative standard deviation of the focal length; 0 if it was given.
    """

    mount: CameraMount
    fit: MountFit
    tilt: float
    sigma_tilt: float
    sigma_height: float
    pixel: float
    sigma_pixel: float
    sigma_focal: float


def calibrate(
    dots: DetectedDots,
    mat: DotMap,
    camera: PinholeCamera,
    initial_mount: CameraMount,
    *,
    focal_length_known: bool = True,
    known_height: KnownHeight | None = None,
    T_mat_base: SE2 | None = None,
) -> CameraCalibration:
    """Calibrate the mount of the camera on the robot.

    Args:
        dots: detected dots of the image of the mat.
        mat: dot map of the mat, with diameters.
        camera: intrinsics; if the focal length is unknown, image size and approximate focal length.
        initial_mount: initial mount; x, y and yaw are taken from it if the robot's pose is unknown.
        focal_length_known: whether the focal length is fixed to that of ``camera``.
        known_height: measured camera height, None if unknown.
        T_mat_base: pose of the robot on the mat, None if unknown.

    Raises:
        FloorLocalizerError: the image is insufficient; the message names the remedy.
    """
    if not np.isfinite(mat.diameters).all():
        raise FloorLocalizerError('--mat: has dots without a diameter; give the map that print_mat wrote')
    if len(dots) < _MIN_DOTS:
        raise FloorLocalizerError(
            f'the image shows {len(dots)} dots, at least {_MIN_DOTS} are needed; show more of the mat'
        )
    matches = match_mat(dots, camera, mat, initial_mount)
    if matches is None:
        raise FloorLocalizerError(
            f'the {len(dots)} dots of the image do not match the mat; give the map with the seed printed on the page, '
            'and --camera-rpy if the camera is tilted by more than 15 degrees'
        )
    fit = fit_mount(dots, mat, matches, camera, fit_focal_length=not focal_length_known, known_height=known_height)
    return _check_accuracy(_calibration(fit, initial_mount, T_mat_base), dots)


def _calibration(fit: MountFit, initial_mount: CameraMount, T_mat_base: SE2 | None) -> CameraCalibration:
    x, y, height = (float(value) for value in fit.position)
    if T_mat_base is None:
        yaw_offset = wrap_angle(_heading(fit.rotation) - _heading(initial_mount.rotation))
        position = np.array(initial_mount.xyz[:2])
    else:
        yaw_offset, position = T_mat_base.yaw, T_mat_base.inverse().transform([[x, y]])[0]
    rotation = Rotation.from_euler('z', -yaw_offset) * Rotation.from_matrix(fit.rotation)
    roll, pitch, yaw = (float(angle) for angle in rotation.as_euler('xyz'))
    mount = CameraMount((float(position[0]), float(position[1]), height), (roll, pitch, yaw))
    sigma_tilt, sigma_height, relative_sigma_pixel, sigma_focal = _sigmas(fit.covariance, height)
    pixel = height / math.sqrt(fit.camera.fx * fit.camera.fy)
    tilt = math.acos(min(-float(fit.rotation[2, 2]), 1.0))
    return CameraCalibration(
        mount, fit, tilt, sigma_tilt, sigma_height, pixel, relative_sigma_pixel * pixel, sigma_focal
    )


def _sigmas(covariance: Floats, height: float) -> tuple[float, float, float, float]:
    """Return the standard deviations of tilt [rad], height [m], and relative ones of pixel size and focal length."""
    if not np.isfinite(covariance).all():
        # The normal matrix is singular: some unknown is unobservable, and its correlations are unknown.
        return math.inf, math.inf, math.inf, math.inf
    variance_focal, variance_height = covariance[6, 6], covariance[5, 5] / height**2
    variances = (
        float(np.linalg.eigvalsh(covariance[:2, :2])[-1]),
        covariance[5, 5],
        variance_height + variance_focal - 2.0 * covariance[5, 6] / height,
        variance_focal,
    )
    tilt, height_sigma, pixel, focal = (math.sqrt(max(variance, 0.0)) for variance in variances)
    return tilt, height_sigma, pixel, focal


def _heading(rotation: Floats) -> float:
    """Return the direction of the image's v axis on the floor [rad]."""
    return math.atan2(float(rotation[1, 1]), float(rotation[0, 1]))


def _check_accuracy(found: CameraCalibration, dots: DetectedDots) -> CameraCalibration:
    """Reject a calibration that is not accurate enough."""
    fit, camera = found.fit, found.fit.camera
    coverage = np.ptp(dots.pixels[fit.inliers], axis=0) / (camera.width, camera.height)
    if fit.dots < _MIN_DOTS or coverage.min() < _MIN_COVERAGE:
        raise FloorLocalizerError(
            f'{fit.dots} dots match on {coverage[0]:.0%} x {coverage[1]:.0%} of the image, at least {_MIN_DOTS} on '
            f'{_MIN_COVERAGE:.0%} are needed; put the mat under the whole view, flat and in focus'
        )
    if fit.residual > _RESIDUAL_MAX:
        raise FloorLocalizerError(
            f'the rms reprojection error is {fit.residual:.2f} px, at most {_RESIDUAL_MAX:g} px is allowed; '
            'flatten the mat, check its scale bar, and give the calibration of this camera'
        )
    if found.sigma_focal > _SIGMA_FOCAL_MAX:
        spread = f' (± {found.sigma_focal:.0%})' if found.sigma_focal < 1.0 else ''
        raise FloorLocalizerError(
            f'focal length and height are not both observable in this view{spread}, only the pixel size: '
            f'{1e3 * found.pixel:.4f} mm; give --calibration, or --height from floor to lens, or tilt the robot'
        )
    if found.sigma_tilt > _SIGMA_TILT_MAX or found.sigma_height > _SIGMA_HEIGHT_MAX * found.mount.xyz[2]:
        raise FloorLocalizerError(
            f'the tilt is known only to ± {math.degrees(found.sigma_tilt):.2f}° and the height to '
            f'± {1e3 * found.sigma_height:.1f} mm; use a denser mat or a sharper image'
        )
    return found
