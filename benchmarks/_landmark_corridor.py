"""A corridor that is taught by its truth: primitives where its landmarks are, as an engineer would choose them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from _stereo_peers import product_rig
from numpy.typing import NDArray

from scene_simulator.corridor.scene import CorridorScene
from scene_simulator.corridor.shapes import Landmark, RoundLandmark
from scene_simulator.corridor.stereo_rig import StereoRig as Cameras
from scene_simulator.corridor.stereo_rig import render_pair
from shirube_core.geometry import SE2
from stereo_landmark.core.primitives.primitive import (
    ImageProcessing,
    Primitive,
    PrimitiveKind,
    invariant_points,
)
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

LANDMARKS = ('meter', 'sign', 'cabinet', 'round')
"""What an engineer would select."""
TAUGHT = SE2(-3.0, 0.0, 0.0)
"""Where the robot stood: ``T_map_place``."""
NEAR = 3.0
"""A detected primitive is that of a landmark when its points are not farther off [px]."""
Pair = tuple[NDArray[np.uint8], NDArray[np.uint8]]


@dataclass(frozen=True)
class TaughtCorridor:
    """A corridor, the cameras, and what was taught of it.

    Attributes:
        scene: the corridor.
        cameras: that see it.
        images: images of the teach pose.
        place: the taught place.
    """

    scene: CorridorScene
    cameras: Cameras
    images: Pair
    place: TaughtPlace


def teach_corridor(scene: CorridorScene, cameras: Cameras) -> TaughtCorridor:
    """Teach a corridor from one pair of images of rectified cameras: all ``LANDMARKS`` that are measurable."""
    processing = ImageProcessing()
    images = render_pair(scene, cameras, TAUGHT, np.random.default_rng(0))
    left, right = (detect_scene(image, processing) for image in images)
    view = StereoView(left, right, product_rig(cameras))
    teacher = Teacher(view, processing)
    parts: dict[str, Primitive] = {}
    for prefix in LANDMARKS:
        for landmark in scene.landmarks:
            found = _primitive_of(landmark, cameras, view) if landmark.name.startswith(prefix) else None
            if found is not None and _is_measurable(teacher, found):
                parts[landmark.name.replace('/', ' ')] = found
    return TaughtCorridor(
        scene, cameras, images, teacher.teach('corridor', [TargetSelection('wall', parts)], TAUGHT)
    )


def _primitive_of(landmark: Landmark, cameras: Cameras, view: StereoView) -> Primitive | None:
    """Return what the left image shows of a landmark."""
    pose = cameras.camera_poses(TAUGHT)[0]
    truth = cameras.left.intrinsics.pixels_from_points(
        pose.camera_points(np.array(list(landmark.points_map().values())))
    )
    kind = PrimitiveKind.ELLIPSE if isinstance(landmark, RoundLandmark) else PrimitiveKind.QUADRILATERAL
    best, least = None, NEAR
    for primitive in view.left.kinds[kind].primitives:
        points = primitive.image_points()
        found = np.array([points[name].position for name in invariant_points(primitive)])
        apart = float(np.linalg.norm(found[:, None] - truth[None], axis=2).min(axis=1).max())
        if apart < least:
            best, least = primitive, apart
    return best


def _is_measurable(teacher: Teacher, primitive: Primitive) -> bool:
    try:
        teacher.measure(primitive)
    except StereoLandmarkError:
        return False
    return True
