"""Images of a printed board through a camera with distortion, whose truth is known."""

import cv2
import numpy as np

from shirube_camera.core.calibration import BoardSettings
from shirube_core.geometry import PinholeCamera, matrix_from_rpy

CAMERA = PinholeCamera(480, 360, 402.0, 404.0, 236.0, 183.0, (-0.21, 0.06, 0.001, -0.0015, 0.0))
RIGHT = PinholeCamera(480, 360, 396.0, 397.0, 244.0, 176.0, (-0.19, 0.05, -0.001, 0.001, 0.0))
R_RIGHT_LEFT, BASELINE = matrix_from_rpy((0.01, -0.03, 0.015)), 0.08
BOARD = BoardSettings(square=0.03)
_OVERSAMPLING = 2


def poses(count, seed=0):
    """Return rotations and centres of a tilted board all over the image, in the left camera's frame."""
    random = np.random.default_rng(seed)
    for k in range(count):
        tilt = np.array([(0.5, 0.0), (-0.5, 0.1), (0.0, 0.5), (0.1, -0.5)][k % 4]) + random.normal(0.0, 0.08, 2)
        distance = random.uniform(0.45, 0.65)
        u, v = random.uniform(-0.24, 0.24), random.uniform(-0.2, 0.2)
        yield matrix_from_rpy((*tilt, random.uniform(-0.3, 0.3))), distance * np.array([u, v, 1.0])


def seen_from_right(R, centre):
    return R_RIGHT_LEFT @ R, R_RIGHT_LEFT @ (centre - (BASELINE, 0.0, 0.0))


def in_image(camera, R, centre, corners):
    """Return the true pixels of the board's corners."""
    return camera.pixels_from_points((corners - corners.mean(axis=0)) @ R.T + centre)


class Renderer:
    """Renders boards; the rays of all pixels are computed once."""

    def __init__(self, camera, settings=BOARD):
        n, squares = _OVERSAMPLING, np.indices((settings.rows + 1, settings.columns + 1)).sum(axis=0) % 2
        y, x = ((np.mgrid[: camera.height * n, : camera.width * n] + 0.5) / n) - 0.5
        self.rays = np.nan_to_num(camera.rays_from_pixels(np.column_stack([x.ravel(), y.ravel()])), nan=9.0)
        print_ = np.kron(np.where(squares, 215, 25), np.ones((32, 32))).astype(np.uint8)
        self.print = cv2.copyMakeBorder(print_, 32, 32, 32, 32, cv2.BORDER_CONSTANT, value=215)
        self.scale, self.shape = 32 / settings.square, y.shape
        self.random = np.random.default_rng(1)

    def __call__(self, R, centre):
        depth = (R[:, 2] @ centre) / (self.rays @ R[:, 2])
        on_board = (self.rays * depth[:, None] - centre) @ R[:, :2] * self.scale
        u, v = (on_board + 0.5 * np.array(self.print.shape[::-1]) - 0.5).T.reshape(2, *self.shape).astype(np.float32)
        fine = cv2.remap(self.print, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=90)
        image = cv2.resize(fine, self.shape[::-1], interpolation=cv2.INTER_AREA)
        image = cv2.resize(image, None, fx=1 / _OVERSAMPLING, fy=1 / _OVERSAMPLING, interpolation=cv2.INTER_AREA)
        noise = self.random.normal(0.0, 2.0, image.shape)
        return (cv2.GaussianBlur(image, (0, 0), 0.6) + noise).clip(0, 255).astype(np.uint8)
