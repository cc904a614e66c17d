"""Coarse poses: predicted pixels of many pose hypotheses, and the fit of a pose to detected primitives.

The fit is accurate enough for guided matching. It minimizes the same robust cost as `core.place.reprojection`, but all
detected coordinates have the same noise, and roll and pitch are fixed. Many hypotheses are fitted in a millisecond.
"""

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, Masks
from stereo_landmark.core.least_squares import invert_symmetric
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.stereo import CameraView, StereoRig

DETECTED_SIGMA = 0.7
"""Standard deviation of a detected primitive before its refinement in the grey image [px]."""
HUBER_THRESHOLD = 3.0
"""Threshold of the Huber loss [standard deviations]."""
ITERATIONS_MAX = 20
STEP_TOLERANCE = 1e-5
"""Convergence: the iteration stops when the step is smaller than this [m, rad]."""
DEPTH_MIN = 0.05
"""Nearer points do not count in the fit [m]."""
PREDICTED_DEPTH_MIN = 0.2
"""Nearer points have no predicted pixels [m]."""
BORDER_MARGIN = 8.0
"""Primitives predicted nearer to the border may be out of view [px]."""


def predict_pixels(states: Floats, positions: Floats, view: CameraView) -> Floats:
    """Return predicted pixels, shape (h, k, 4): u, v left and u, v right [px]; NaN behind the cameras.

    Args:
        states: x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (h, 4).
        positions: points in the place's frame, shape (k, 3) [m].
        view: stereo view with cameras and tilt.
    """
    return np.asarray(_project(states, positions, view.camera.rotation, view.camera.position, stereo_intrinsics(view)))


def is_in_view(pixels: Floats, rig: StereoRig) -> Masks:
    """Return the mask of predicted pixels u, v, shape (h, k, 2) or more, inside an image, shape (h, k)."""
    width, height = rig.left.width, rig.left.height
    u, v = pixels[..., 0], pixels[..., 1]
    return np.asarray(
        (u > BORDER_MARGIN) & (u < width - 1 - BORDER_MARGIN) & (v > BORDER_MARGIN) & (v < height - 1 - BORDER_MARGIN)
    )


def image_distances(states: Floats, positions: Floats, view: CameraView) -> Floats:
    """Return the largest image distance of the points between each pose and the first pose, shape (h,) [px].

    Points behind the cameras of one of both poses are ignored; the distance is infinite if no point is visible in both.

    Args:
        states: x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (h, 4).
        positions: points in the place's frame, shape (k, 3) [m].
        view: stereo view with cameras and tilt.
    """
    pixels = predict_pixels(states, positions, view)[..., :2]
    distances = np.hypot(*(pixels - pixels[:1]).transpose(2, 0, 1))
    farthest = np.fmax.reduce(distances, axis=1)
    return np.where(np.isnan(farthest), np.inf, farthest)


def poses_from_match(taught: Floats, found: Floats, yaws: Floats) -> Floats:
    """Return the poses that map a taught point to its matches, shape (n, h, 4): x, y, z [m], yaw [rad].

    Args:
        taught: taught point in the place's frame, shape (3,) [m].
        found: matched points in the current gravity-aligned base frame, shape (n, 3) [m].
        yaws: yaw hypotheses, shape (h,) [rad].
    """
    cos, sin = np.cos(yaws), np.sin(yaws)
    x, y, z = (found[:, None, axis] for axis in range(3))
    states = np.empty((len(found), len(yaws), 4))
    states[..., 0] = taught[0] - (cos * x - sin * y)
    states[..., 1] = taught[1] - (sin * x + cos * y)
    states[..., 2] = taught[2] - z
    states[..., 3] = yaws
    return states


def stereo_intrinsics(view: CameraView) -> Floats:
    """Return the intrinsics for the kernels: fx, fy, cx, cy, fx and cx of the right camera [px], baseline [m]."""
    left, right = view.rig.left, view.rig.right
    return np.array([left.fx, left.fy, left.cx, left.cy, right.fx, right.cx, view.rig.baseline])


def fit_coarse_pose(
    start: Floats, taught: Floats, covariances: Floats, seen: Floats, view: StereoView
) -> Floats | None:
    """Fit x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (4,); None if they are not observable.

    Args:
        start: initial state, shape (4,).
        taught: taught points in the place's frame, shape (n, 3) [m].
        covariances: covariances of the taught points, shape (n, 3, 3) [m²].
        seen: measured u, v left and u, v right, shape (n, 4) [px].
        view: stereo view with cameras and tilt.
    """
    if len(seen) < 2:
        return None
    state = start.copy()
    camera = view.camera
    is_known = _gauss_newton(
        state, taught, covariances, seen, camera.rotation, camera.position, stereo_intrinsics(view)
    )
    return state if is_known else None


@njit(cache=True, error_model='numpy')
def _project(states: Floats, positions: Floats, rotation: Floats, position: Floats, intrinsics: Floats) -> Floats:
    pixels = np.full((len(states), len(positions), 4), np.nan)
    optical = np.empty(3)
    for h in range(len(states)):
        cos, sin = np.cos(states[h, 3]), np.sin(states[h, 3])
        for k in range(len(positions)):
            x, y = positions[k, 0] - states[h, 0], positions[k, 1] - states[h, 1]
            ahead, left = cos * x + sin * y - position[0], cos * y - sin * x - position[1]
            up = positions[k, 2] - states[h, 2] - position[2]
            for c in range(3):
                optical[c] = rotation[0, c] * ahead + rotation[1, c] * left + rotation[2, c] * up
            if optical[2] > PREDICTED_DEPTH_MIN:
                pixels[h, k, 0] = intrinsics[0] * optical[0] / optical[2] + intrinsics[2]
                pixels[h, k, 1] = intrinsics[1] * optical[1] / optical[2] + intrinsics[3]
                pixels[h, k, 2] = intrinsics[4] * (optical[0] - intrinsics[6]) / optical[2] + intrinsics[5]
                pixels[h, k, 3] = pixels[h, k, 1]
    return pixels


@njit(cache=True, error_model='numpy')
def _gauss_newton(
    state: Floats,
    taught: Floats,
    covariances: Floats,
    seen: Floats,
    rotation: Floats,
    position: Floats,
    intrinsics: Floats,
) -> bool:
    """Write the fitted state (reweighted Gauss-Newton); return whether it is observable."""
    information, gradient, inverse = np.empty((4, 4)), np.empty(4), np.empty((4, 4))
    for _ in range(ITERATIONS_MAX):
        camera = (*_camera_pose(state, rotation, position), intrinsics)
        _write_normal_equations(state, taught, covariances, seen, camera, information, gradient)
        if not invert_symmetric(information, inverse):
            return False
        step = inverse @ gradient
        state += step
        if np.max(np.abs(step)) < STEP_TOLERANCE:
            break
    state[3] = (state[3] + np.pi) % (2.0 * np.pi) - np.pi
    return True


@njit(cache=True, error_model='numpy')
def _camera_pose(state: Floats, rotation: Floats, position: Floats) -> tuple[Floats, Floats]:
    """Return the camera's axes, shape (3, 3), column by column, and its position in the place's frame, shape (3,)."""
    cos, sin = np.cos(state[3]), np.sin(state[3])
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return turn @ rotation, state[:3] + turn @ position


@njit(cache=True, error_model='numpy')
def _write_normal_equations(
    state: Floats,
    taught: Floats,
    covariances: Floats,
    seen: Floats,
    camera: tuple[Floats, Floats, Floats],
    information: Floats,
    gradient: Floats,
) -> None:
    """Write the normal equations of a step; the camera is its axes, position and intrinsics."""
    jacobian, residual = np.empty((3, 4)), np.empty(3)
    spread, weights = np.empty((3, 3)), np.empty((3, 3))
    information[:], gradient[:] = 0.0, 0.0
    for n in range(len(taught)):
        if not _linearize(state, taught[n], seen[n], camera, jacobian, residual):
            continue
        _write_weights(jacobian, residual, covariances[n], seen[n, 1] - seen[n, 3], spread, weights)
        for i in range(4):
            for m in range(3):
                weighted = 0.0
                for k in range(3):
                    weighted += jacobian[k, i] * weights[k, m]
                gradient[i] += weighted * residual[m]
                for j in range(4):
                    information[i, j] += weighted * jacobian[m, j]


@njit(cache=True, error_model='numpy')
def _write_weights(
    jacobian: Floats, residual: Floats, covariance: Floats, row_difference: float, spread: Floats, weights: Floats
) -> None:
    """Write the information of u left, mean v and u right, with the Huber weight."""
    variance = DETECTED_SIGMA**2
    # The derivative by a taught point is that by the robot's position with the opposite sign.
    for i in range(3):
        a, b, c = jacobian[i, 0], jacobian[i, 1], jacobian[i, 2]
        x = a * covariance[0, 0] + b * covariance[1, 0] + c * covariance[2, 0]
        y = a * covariance[0, 1] + b * covariance[1, 1] + c * covariance[2, 1]
        z = a * covariance[0, 2] + b * covariance[1, 2] + c * covariance[2, 2]
        for j in range(3):
            spread[i, j] = x * jacobian[j, 0] + y * jacobian[j, 1] + z * jacobian[j, 2]
        spread[i, i] += 0.5 * variance if i == 1 else variance
    for i in range(3):
        for j in range(3):
            k, m, n, p = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
            weights[i, j] = spread[k, n] * spread[m, p] - spread[k, p] * spread[m, n]
    scale = 0.0
    for j in range(3):
        scale += spread[0, j] * weights[0, j]
    squares = 0.5 * row_difference**2 / variance
    for i in range(3):
        for j in range(3):
            weights[i, j] /= scale
            squares += residual[i] * weights[i, j] * residual[j]
    huber_weight = min(1.0, HUBER_THRESHOLD / max(np.sqrt(squares), 1e-9))
    for i in range(3):
        for j in range(3):
            weights[i, j] *= huber_weight


@njit(cache=True, error_model='numpy')
def _linearize(
    state: Floats,
    taught: Floats,
    seen: Floats,
    camera: tuple[Floats, Floats, Floats],
    jacobian: Floats,
    residual: Floats,
) -> bool:
    """Write residual and Jacobian of u left, mean v and u right of a point; return whether it is visible."""
    axes, camera_position, intrinsics = camera
    dx, dy, dz = (taught[0] - camera_position[0], taught[1] - camera_position[1], taught[2] - camera_position[2])
    x = axes[0, 0] * dx + axes[1, 0] * dy + axes[2, 0] * dz
    y = axes[0, 1] * dx + axes[1, 1] * dy + axes[2, 1] * dz
    z = axes[0, 2] * dx + axes[1, 2] * dy + axes[2, 2] * dz
    if z <= DEPTH_MIN:
        return False
    scale_u, scale_v, scale_right = intrinsics[0] / z, intrinsics[1] / z, intrinsics[4] / z
    u, v, right = x / z, y / z, (x - intrinsics[6]) / z
    # Yaw rotates about the robot's base, not about the camera.
    ex, ey = taught[0] - state[0], taught[1] - state[1]
    for i in range(4):
        if i < 3:
            by_x, by_y, by_z = -axes[i, 0], -axes[i, 1], -axes[i, 2]
        else:
            by_x, by_y = axes[0, 0] * ey - axes[1, 0] * ex, axes[0, 1] * ey - axes[1, 1] * ex
            by_z = axes[0, 2] * ey - axes[1, 2] * ex
        jacobian[0, i] = scale_u * (by_x - u * by_z)
        jacobian[1, i] = scale_v * (by_y - v * by_z)
        jacobian[2, i] = scale_right * (by_x - right * by_z)
    residual[0] = seen[0] - intrinsics[0] * u - intrinsics[2]
    residual[1] = 0.5 * (seen[1] + seen[3]) - intrinsics[1] * v - intrinsics[3]
    residual[2] = seen[2] - intrinsics[4] * right - intrinsics[5]
    return True
