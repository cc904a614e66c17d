"""A corridor that is taught by its truth: primitives where its landmarks are, as an engineer would choose them."""

from contextlib import suppress
from typing import NamedTuple

import numpy as np
from _stereo_scenes import CAMERAS, RIG, Pair, left_pixels

from scene_simulator.corridor.scene import CorridorScene
from scene_simulator.corridor.shapes import Landmark, RoundLandmark
from scene_simulator.corridor.stereo_rig import render_pair
from shirube_core.geometry import SE2
from stereo_landmark.core.primitives.primitive import ImageProcessing, Primitive, PrimitiveKind, invariant_points
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

LANDMARKS = ('meter', 'sign', 'cabinet', 'round')  # what an engineer would select
TAUGHT = SE2(-3.0, 0.0, 0.0)  # where the robot stood: ``T_map_place``
NEAR = 3.0  # A detected primitive is that of a landmark when its points are not farther off [px]


class TaughtCorridor(NamedTuple):
    """The images of the teach pose, and the taught place."""

    images: Pair
    place: TaughtPlace


def teach_corridor(scene: CorridorScene) -> TaughtCorridor:
    """Teach a corridor from one pair of images: all ``LANDMARKS`` that are measurable."""
    processing = ImageProcessing()
    images = render_pair(scene, RIG, TAUGHT, np.random.default_rng(0))
    left, right = (detect_scene(image, processing) for image in images)
    view = StereoView(left, right, CAMERAS)
    teacher = Teacher(view, processing)
    parts: dict[str, Primitive] = {}
    for prefix in LANDMARKS:
        for landmark in scene.landmarks:
            found = _primitive_of(landmark, view) if landmark.name.startswith(prefix) else None
            with suppress(StereoLandmarkError):
                if found is not None and teacher.measure(found):
                    parts[landmark.name.replace('/', ' ')] = found
    return TaughtCorridor(images, teacher.teach('corridor', [TargetSelection('wall', parts)], TAUGHT))


def _primitive_of(landmark: Landmark, view: StereoView) -> Primitive | None:
    """Return what the left image shows of a landmark."""
    truth = left_pixels(np.array(list(landmark.points_map().values())), TAUGHT)
    kind = PrimitiveKind.ELLIPSE if isinstance(landmark, RoundLandmark) else PrimitiveKind.QUADRILATERAL
    best, least = None, NEAR
    for primitive in view.left.kinds[kind].primitives:
        points = primitive.image_points()
        found = np.array([points[name].position for name in invariant_points(primitive)])
        apart = float(np.linalg.norm(found[:, None] - truth[None], axis=2).min(axis=1).max())
        if apart < least:
            best, least = primitive, apart
    return best
