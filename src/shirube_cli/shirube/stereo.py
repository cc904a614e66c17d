"""The robot's pose at places that were taught once with a stereo camera."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from shirube.inputs import InputError, as_camera, as_grey, as_numbers, as_triple, prepare
from shirube.results import PlaceResult, as_pose
from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer, NoLandmarkFix
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo import StereoRig
from stereo_landmark.core.teaching.primitive_selection import NearestSelection, TargetSelection, select_primitives
from stereo_landmark.core.teaching.teacher import Teacher
from stereo_landmark.node_settings import NodeSettings


@dataclass(frozen=True)
class Cameras:
    """A rectified stereo pair.

    Attributes:
        left: the left camera after rectification, or the path of its calibration.
        baseline: distance of the right camera from it [m].
        right: the right camera; None if its intrinsics are those of the left one.
        xyz: position of the left camera in the robot's frame [m].
        rpy: fixed-axis roll, pitch, yaw of its optical frame there [rad]; by default it looks ahead.
    """

    left: PinholeCamera | str | Path
    baseline: float
    right: PinholeCamera | str | Path | None = None
    xyz: Sequence[float] = NodeSettings.camera_xyz
    rpy: Sequence[float] = NodeSettings.camera_rpy

    def rig(self) -> StereoRig:
        """Return the cameras as the localizer needs them; raise an InputError or StereoLandmarkError."""
        left = as_camera(self.left)
        right = left if self.right is None else as_camera(self.right)
        mount = CameraMount(as_triple('xyz', self.xyz), as_triple('rpy', self.rpy))
        return StereoRig(left, right, self.baseline, mount)


def teach(
    left: ArrayLike,
    right: ArrayLike,
    cameras: Cameras,
    targets: Mapping[str, Sequence[tuple[str, float, float]]],
    *,
    name: str = 'place',
    pose: Sequence[float] = (0.0, 0.0, 0.0),
) -> TaughtPlace:
    """Teach a place from one rectified pair.

    Args:
        left: left image, shape (h, w) or (h, w, 3) BGR.
        right: right image.
        cameras: the stereo pair.
        targets: primitives of each object: kind (quadrilateral, ellipse, corner, ...) and u, v near them [px].
        name: name of the place.
        pose: x, y [m] and yaw [rad] of the robot in the map now.

    Raises:
        InputError, StereoLandmarkError: an argument that cannot be used, or a primitive that is not there.
    """
    rig, processing = cameras.rig(), ImageProcessing()
    images = as_grey(left, rig.left), as_grey(right, rig.right)
    chosen = {target: [_selection(*primitive) for primitive in given] for target, given in targets.items()}
    T_map_place = SE2(*as_triple('pose', pose))
    prepare('stereo_landmark')
    scenes = [detect_scene(image, processing) for image in images]
    teacher = Teacher(StereoView(scenes[0], scenes[1], rig), processing)
    selections = [TargetSelection(target, select_primitives([*given], scenes[0])) for target, given in chosen.items()]
    return teacher.teach(name, selections, T_map_place)


def locate(places: TaughtPlace | Sequence[TaughtPlace], left: ArrayLike, right: ArrayLike) -> PlaceResult:
    """Return the pose at one of the taught places from one rectified pair, or the reason for none.

    Args:
        places: what `teach` returned.
        left: left image of the same cameras, shape (h, w) or (h, w, 3) BGR.
        right: right image.

    Raises:
        InputError, StereoLandmarkError: an argument that cannot be used.
    """
    known = [places] if isinstance(places, TaughtPlace) else list(places)
    localizer = LandmarkLocalizer(known)
    rig = known[0].rig
    images = as_grey(left, rig.left), as_grey(right, rig.right)
    prepare('stereo_landmark')
    found = localizer.locate(*images)
    if isinstance(found, NoLandmarkFix) or found.T_map_base is None:
        return PlaceResult(
            reason=f'{found.reason} ({found.detail})'
            if isinstance(found, NoLandmarkFix)
            else 'the place has no pose in the map'
        )
    return PlaceResult(as_pose(found.T_map_base), found.map_covariance, place=found.place.name)


def _selection(kind: str, u: float, v: float) -> NearestSelection:
    kinds = [each.value for each in PrimitiveKind]
    if kind not in kinds:
        raise InputError(f'there is no primitive {kind!r}; choose one of: {", ".join(kinds)}')
    u, v = as_numbers('u, v', np.array([u, v]), (2,)).tolist()
    return NearestSelection(PrimitiveKind(kind), (u, v))
