"""Taught data of a place (paper 3.3): targets made of primitives, their points, and context landmarks.

Also the walls of circles: the centre of an imaged circle is not the projection of its centre, and the offset changes
with the viewpoint.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from shirube_core.geometry import SE2, PinholeCamera, matrix_from_rpy
from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.features.taught_features import TaughtPair
from stereo_landmark.core.primitives.primitive import (
    ImageProcessing,
    Primitive,
    PrimitiveKind,
    primitive_kind,
    primitive_size,
)
from stereo_landmark.core.stereo import CameraView, SpatialPoints, StereoImages, StereoRig


@dataclass(frozen=True)
class TaughtPrimitive:
    """One taught primitive.

    Attributes:
        name: name, unique in its target.
        shape: shape in the taught left image, with zero covariance.
        position: centre in the place's frame, shape (3,) [m].
        normal: normal of the wall of a circle, shape (3,), in the place's frame; None for other kinds.
    """

    name: str
    shape: Primitive
    position: Floats
    normal: Floats | None = None

    @property
    def kind(self) -> PrimitiveKind:
        """Kind of the primitive."""
        return primitive_kind(self.shape)

    @property
    def size(self) -> float:
        """Size in the taught left image [px]."""
        return primitive_size(self.shape)


@dataclass(frozen=True)
class TaughtTarget:
    """An object to detect, described by primitives (paper 3.2).

    Attributes:
        name: name, unique in its place.
        primitives: primitives in the order of detection, the most reliable first (paper 3.3c).
        points: names of the corresponding points, ``primitive/point`` (paper 3.3d).
        processing: image processing of its own; None for that of the place.
    """

    name: str
    primitives: tuple[TaughtPrimitive, ...]
    points: tuple[str, ...]
    processing: ImageProcessing | None = None

    @property
    def positions(self) -> Floats:
        """Centres of the primitives in the place's frame, shape (k, 3) [m]."""
        return np.array([primitive.position for primitive in self.primitives])


@dataclass(frozen=True)
class TaughtPlace:
    """A taught place. Its frame is the gravity-aligned base frame of the robot at teaching time.

    Attributes:
        name: name of the place and of its frame.
        rig: stereo cameras used for teaching (paper 3.3a).
        processing: image processing parameters (paper 3.3b).
        targets: objects to detect (paper 3.3c and d).
        coordinates: taught points, named ``target/primitive/point`` (paper 3.3e).
        context_landmarks: context landmarks: other primitives around the targets, which disambiguate similar targets.
        T_map_place: pose of the place in the map, None if unknown.
        images: images used for teaching, None if not available.
        pair: these images with the cameras used for teaching, which may have been calibrated again since; made from
            images and rig.
    """

    name: str
    rig: StereoRig
    targets: tuple[TaughtTarget, ...]
    coordinates: SpatialPoints
    context_landmarks: tuple[TaughtPrimitive, ...] = ()
    processing: ImageProcessing = field(default_factory=ImageProcessing)
    T_map_place: SE2 | None = None
    images: StereoImages | None = field(default=None, compare=False, repr=False)
    pair: TaughtPair | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.images is not None and (self.pair is None or self.pair.images is not self.images):
            object.__setattr__(self, 'pair', TaughtPair(self.images, self.rig))

    @property
    def kinds(self) -> set[PrimitiveKind]:
        """Kinds of primitives to detect."""
        taught = [primitive for target in self.targets for primitive in target.primitives]
        return {primitive.kind for primitive in (*taught, *self.context_landmarks)}


WALL_TOLERANCE = 0.05
"""Maximum distance from a plane of landmarks that are on that wall [m]."""
WALL_WIDTH_MIN = 0.2
"""Minimum horizontal distance of two landmarks that determine the direction of a wall [m]."""


def wall_normal(position: Floats, others: Floats) -> Floats:
    """Return the normal of the vertical wall that a landmark is on, shape (3,), towards the robot.

    Walls are vertical, so landmarks on a wall are collinear in the horizontal plane. Of the lines through the landmark
    and another one, the line with the most landmarks is used; without such a line the wall faces the robot.

    Args:
        position: landmark in the place's frame, shape (3,) [m].
        others: landmarks around it, shape (n, 3) [m].
    """
    facing = -position[:2] / max(float(np.hypot(*position[:2])), 1e-9)
    offsets = others[:, :2] - position[:2]
    lengths = np.hypot(offsets[:, 0], offsets[:, 1])
    best, normal = 1, facing
    for i in np.flatnonzero(lengths >= WALL_WIDTH_MIN):
        along = offsets[i] / lengths[i]
        across = np.array([-along[1], along[0]])
        on_wall = np.abs(offsets @ across) <= WALL_TOLERANCE
        if on_wall.sum() > best:
            best = int(on_wall.sum())
            normal = _line_normal(offsets[on_wall])
    return np.array([*(normal if normal @ facing > 0.0 else -normal), 0.0])


def _line_normal(offsets: Floats) -> Floats:
    """Return the unit normal of the line through points and the origin, shape (2,)."""
    angle = 0.5 * math.atan2(
        2.0 * float(offsets[:, 0] @ offsets[:, 1]), float(offsets[:, 0] @ offsets[:, 0] - offsets[:, 1] @ offsets[:, 1])
    )
    return np.array([-math.sin(angle), math.cos(angle)])


def centre_correction(taught: TaughtPrimitive, state: Floats, view: CameraView) -> Floats:
    """Return how far the apparent centre of a circle moved on the wall since it was taught.

    Args:
        taught: taught primitive; the correction is zero for anything but circles.
        state: x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (4,).
        view: stereo view with cameras and tilt.

    Returns:
        correction of u, v left and u, v right, shape (4,) [px].
    """
    if taught.normal is None:
        return np.zeros(4)
    now, at_teaching = (_centre_offsets(taught, taught.normal, each, view) for each in (state, np.zeros(4)))
    return now - at_teaching


def _centre_offsets(taught: TaughtPrimitive, normal_place: Floats, state: Floats, view: CameraView) -> Floats:
    """Return the ellipse centre minus the circle centre in both images, shape (4,) [px]."""
    R_place_camera = matrix_from_rpy((0.0, 0.0, float(state[3]))) @ view.camera.rotation
    camera_position = state[:3] + matrix_from_rpy((0.0, 0.0, float(state[3]))) @ view.camera.position
    centre, normal = (taught.position - camera_position) @ R_place_camera, normal_place @ R_place_camera
    if centre[2] <= 0.0:
        return np.zeros(4)
    # The radius follows from the apparent size in the taught image.
    depth = float(((taught.position - view.camera.position) @ view.camera.rotation)[2])
    radius = taught.size * depth / view.rig.left.fx
    right = centre - [view.rig.baseline, 0.0, 0.0]
    return np.concatenate(
        [
            ellipse_centre_offset(centre, normal, radius, view.rig.left),
            ellipse_centre_offset(right, normal, radius, view.rig.right),
        ]
    )


def ellipse_centre_offset(centre: Floats, normal: Floats, radius: float, camera: PinholeCamera) -> Floats:
    """Return the ellipse centre minus the projected circle centre, shape (2,) [px].

    The plane's homography maps the circle's conic into the image; the ellipse's centre is the pole of the
    line at infinity.

    Args:
        centre: circle centre in the optical frame, shape (3,) [m].
        normal: normal of the circle's plane, shape (3,), not necessarily a unit vector.
        radius: circle radius [m].
        camera: pinhole camera without distortion.
    """
    plane_axes = np.linalg.svd(normal[None, :])[2][1:]
    K = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
    homography = K @ np.column_stack([radius * plane_axes[0], radius * plane_axes[1], centre])
    inverse = np.linalg.inv(homography)
    conic = inverse.T @ np.diag([1.0, 1.0, -1.0]) @ inverse
    ellipse_centre = -np.linalg.solve(conic[:2, :2], conic[:2, 2])
    projection = K @ (centre / centre[2])
    return np.asarray(ellipse_centre - projection[:2])
