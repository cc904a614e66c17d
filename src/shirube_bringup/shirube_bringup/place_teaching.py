"""Teaches the mission's places from rendered image pairs without obstacles, as a user would in the teaching page."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from scene_simulator.corridor_landmark import Landmark, RoundLandmark
from scene_simulator.mission_landmarks import FurnishedScene, bare_walls, landmarks_on_wall
from scene_simulator.mission_layout import NOMINAL
from scene_simulator.mission_sensors import STEREO_RIG
from scene_simulator.stereo_rig import render_pair
from shirube_core.geometry import SE2
from stereo_landmark.core.primitives.primitive import (
    ImageProcessing,
    Primitive,
    PrimitiveKind,
    invariant_points,
)
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.stereo import StereoImages, StereoRig
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher
from stereo_landmark.files.place_file import save_place

PLACES = {
    'east_near': (NOMINAL.goals[0], 'east'),
    'east_far': (SE2(4.4, 1.2, 0.0), 'east'),
    'north_near': (NOMINAL.goals[1], 'north'),
    'north_far': (SE2(6.3, 2.6, 0.5 * math.pi), 'north'),
    'west_near': (NOMINAL.goals[2], 'west'),
    'west_far': (SE2(3.6, 4.6, math.pi), 'west'),
}
"""Pose of the robot and visible wall of each taught place."""

_TOLERANCE = 3.0
"""Largest distance between the points of a detected primitive and those of its landmark [px]."""


def teach_places(folder: Path) -> None:
    """Teach all places and write them to a folder.

    Raises:
        StereoLandmarkError: a place cannot be taught.
        OSError: the folder is not writable.
    """
    walls = bare_walls()
    rig = StereoRig(
        STEREO_RIG.left.intrinsics, STEREO_RIG.right.intrinsics, STEREO_RIG.baseline, STEREO_RIG.mount
    )
    for number, (name, (pose, wall)) in enumerate(PLACES.items()):
        camera_position = STEREO_RIG.camera_poses(pose)[0].position
        scene = FurnishedScene(walls).order_for_camera(camera_position)
        images = render_pair(scene, STEREO_RIG, pose, np.random.default_rng(number))
        processing = ImageProcessing()
        left, right = (detect_scene(image, processing) for image in images)
        teacher = Teacher(StereoView(left, right, rig), processing)
        visible = dict(
            _visible_landmarks(landmarks_on_wall(walls, wall), pose, StereoView(left, right, rig), teacher)
        )
        place = teacher.teach(name, [TargetSelection('wall', visible)], pose)
        save_place(folder, place, StereoImages(*images))


def _visible_landmarks(
    landmarks: tuple[Landmark, ...], pose: SE2, view: StereoView, teacher: Teacher
) -> Iterator[tuple[str, Primitive]]:
    """Yield name and primitive of the landmarks that can be measured in both images."""
    for landmark in landmarks:
        found = _find_primitive(landmark, pose, view)
        if found is not None and teacher.can_measure(found):
            yield landmark.name.replace('/', ' '), found


def _find_primitive(landmark: Landmark, pose: SE2, view: StereoView) -> Primitive | None:
    """Return the primitive of a landmark in the left image, None if not found."""
    points_map = np.array(list(landmark.points_map().values()))
    points = STEREO_RIG.camera_poses(pose)[0].camera_points(points_map)
    truth = STEREO_RIG.left.intrinsics.pixels_from_points(points)
    kind = PrimitiveKind.ELLIPSE if isinstance(landmark, RoundLandmark) else PrimitiveKind.QUADRILATERAL
    best, smallest_error = None, _TOLERANCE
    for primitive in view.left.kinds[kind].primitives:
        named = primitive.image_points()
        found = np.array([named[name].position for name in invariant_points(primitive)])
        error = float(np.linalg.norm(found[:, None] - truth[None], axis=2).min(axis=1).max())
        if error < smallest_error:
            best, smallest_error = primitive, error
    return best
