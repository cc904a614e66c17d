"""SIFT features with FLANN and a vote, on rendered pictures of a patch of floor.

The patch is 1.8 x 1.2 m, an eighth of the paper's floor: the picture of all of it at the camera's resolution would take
a gigabyte of descriptors. Chips are missing and added as in the views of dots; there is no noise of centroids, as the
picture has none, and neither the camera's height nor tilt is off.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np
from _paper_views import CAMERA, MOUNT, VIEW_SIZE
from numpy.typing import NDArray

from scene_simulator.floor.camera import FloorCamera
from scene_simulator.floor.disturbances import Litter
from scene_simulator.floor.dot_floor import DARK_ON_LIGHT, DotFloor, FloorDesign, generate_dot_floor
from shirube_core.geometry import SE2, PinholeCamera

PATCH = (1.8, 1.2)
DENSITY = DARK_ON_LIGHT.count / math.prod(DARK_ON_LIGHT.size)
# Lowe's ratio of the best to the second best, inliers that a pose needs, and by how much its scale may be off.
RATIO, LEAST_INLIERS, SCALE_ERROR = 0.85, 6, 0.05
_TILE = 1200
_KD_TREES = {'algorithm': 1, 'trees': 4}


class Features(NamedTuple):
    """What SIFT sees in a picture: places in the view's frame, shape (n, 2) [m], and descriptors, shape (n, 128)."""

    points: NDArray[np.float32]
    descriptors: NDArray[np.float32]


def patch_floor(seed: int) -> DotFloor:
    """Return the patch, as dense as the paper's floor."""
    return generate_dot_floor(FloorDesign(size=PATCH, count=round(DENSITY * math.prod(PATCH))), seed)


def pictures(
    floor: DotFloor, number: int, missing: float, spurious: float, seed: int
) -> Iterator[tuple[NDArray[np.uint8], SE2]]:
    """Yield pictures at random places of the patch and the true poses; rates are relative to the chips in view."""
    camera = FloorCamera(intrinsics=CAMERA)
    margin = VIEW_SIZE / math.sqrt(2.0)
    others = FloorDesign(size=PATCH, count=max(round(spurious * len(floor)), 1))
    for k in range(number):
        rng = np.random.default_rng([seed, k])
        x, y = rng.uniform(margin, np.array(PATCH) - margin).tolist()
        pose = SE2(x, y, float(rng.uniform(-math.pi, math.pi)))
        added = Litter(generate_dot_floor(others, 1000 + k).chips)
        left = floor.remove_chips(missing, k)
        yield camera.photograph(left, [pose], MOUNT, disturbances=(added,), rng=rng).image, pose


class SiftMatcher:
    """Locates pictures on one patch."""

    def __init__(self, floor: DotFloor) -> None:
        """Photograph the patch tile by tile and index its features."""
        self._sift = cv2.SIFT.create()
        places, descriptors = [], []
        side = _TILE * MOUNT.xyz[2] / CAMERA.fx
        tile = PinholeCamera(_TILE, _TILE, CAMERA.fx, CAMERA.fy, (_TILE - 1) / 2.0, (_TILE - 1) / 2.0)
        camera = FloorCamera(intrinsics=tile)
        for x in np.arange(side / 2.0, PATCH[0] + side / 2.0, 0.8 * side):
            for y in np.arange(side / 2.0, PATCH[1] + side / 2.0, 0.8 * side):
                pose = SE2(float(x), float(y), 0.0)
                points, described = self._detect(camera.photograph(floor, [pose], MOUNT).image, tile)
                places.append(pose.transform(points))
                descriptors.append(described)
        self._places = np.vstack(places).astype(np.float32)
        self._matcher = cv2.FlannBasedMatcher(_KD_TREES, {'checks': 64})
        self._matcher.add([np.vstack(descriptors)])
        self._matcher.train()

    def features(self, image: NDArray[np.uint8]) -> Features:
        """Return the features of a picture."""
        points, descriptors = self._detect(image, CAMERA)
        return Features(points.astype(np.float32), descriptors)

    def _detect(
        self, image: NDArray[np.uint8], camera: PinholeCamera
    ) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
        keypoints, descriptors = self._sift.detectAndCompute(image, None)
        pixels = np.array([keypoint.pt for keypoint in keypoints])
        return MOUNT.floor_points_from_rays(camera.rays_from_pixels(pixels)), np.asarray(descriptors)

    def locate(self, features: Features) -> SE2 | None:
        """Return the pose that most features agree on."""
        pairs = self._matcher.knnMatch(features.descriptors, k=3)
        view, on_map = [], []
        for matches in pairs:
            # Tiles overlap, so that the same feature may come twice: the third is the runner-up of the ratio test.
            best, others = matches[0], matches[1:]
            if len(others) == 2 and best.distance < RATIO * others[1].distance:
                view.append(features.points[best.queryIdx])
                on_map.append(self._places[best.trainIdx])
        if len(view) < LEAST_INLIERS:
            return None
        similarity, inliers = cv2.estimateAffinePartial2D(
            np.array(view), np.array(on_map), ransacReprojThreshold=0.001, maxIters=2000
        )
        if similarity is None or int(inliers.sum()) < LEAST_INLIERS:
            return None
        a, b = float(similarity[0, 0]), float(similarity[1, 0])
        if abs(math.hypot(a, b) - 1.0) > SCALE_ERROR:
            return None
        return SE2(float(similarity[0, 2]), float(similarity[1, 2]), math.atan2(b, a))
