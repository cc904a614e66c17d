"""Target sets as an engineer would choose them with the teaching tools, without a look at the other pair or the truth.

The rule: of the quadrilaterals and corners of the left image that both images show and the tools measure, those whose
points are all known to ±3 cm, whose sides or arms are at least 15 px long, and that are 6 % of the width from the
border. Of these sixteen are drawn at random, their middles at least 25 px apart. A set to which the tools have a
remark is drawn again.
"""

import numpy as np
from _real_pairs import Moment
from numpy.typing import NDArray

from stereo_landmark.commands.teach import undetected_targets
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.core.primitives.corner import Corner
from stereo_landmark.core.primitives.primitive import ImageProcessing, Primitive, PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene, stereo_points
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import EdgeSettings
from stereo_landmark.core.stereo import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.hints import check_geometry
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

KINDS = (PrimitiveKind.QUADRILATERAL, PrimitiveKind.CORNER)
POINT_SIGMA_MAX = 0.03  # [m]
SIDE_MIN, APART = 15.0, 25.0  # [px]
BORDER_SHARE = 0.06  # of the width
PRIMITIVES = 16
DRAWS_MAX = 20


class TargetChooser:
    """Chooses target sets in one pair of images, with a threshold of edges [grey levels / px].

    Far scenes need a larger standard deviation of the points [m], and have fewer primitives.
    """

    def __init__(
        self,
        moment: Moment,
        rig: StereoRig,
        threshold: float = EdgeSettings().threshold,
        sigma_max: float = POINT_SIGMA_MAX,
        primitives: int = PRIMITIVES,
    ) -> None:
        self._sigma_max, self._primitives = sigma_max, primitives
        processing = ImageProcessing(edges=EdgeSettings(threshold=threshold))
        left, right = (detect_scene(image, processing) for image in (moment.left, moment.right))
        self._moment = moment
        self._view = StereoView(left, right, rig, moment.tilt)
        self._teacher = Teacher(self._view, processing)
        kinds = (self._view.left.kinds[kind].primitives for kind in KINDS)
        self.candidates = [each for primitives in kinds for each in primitives if self._is_good(each)]

    def place(self, seed: int) -> TaughtPlace:
        """Return a place with one target of sixteen primitives.

        Raises:
            StereoLandmarkError: the tools remark on all sets.
        """
        rng = np.random.default_rng(seed)
        for _ in range(DRAWS_MAX):
            place = self._teacher.teach('room', [TargetSelection('room', self._draw_target(rng))])
            if not self._remarks(place):
                return place
        raise StereoLandmarkError(f'seed {seed}: the tools remark on {DRAWS_MAX} sets; choose others')

    def _remarks(self, place: TaughtPlace) -> list[str]:
        """Return what the tools remark on a place."""
        moment = self._moment
        answer = LandmarkLocalizer([place]).locate(moment.left, moment.right, moment.tilt)
        fix = answer.displacement if isinstance(answer, LandmarkFix) else None
        names = tuple(f'{target.name}/{point}' for target in place.targets for point in target.points)
        return undetected_targets(answer) + check_geometry(place.coordinates.select(names).positions, fix)

    def _draw_target(self, rng: np.random.Generator) -> dict[str, Primitive]:
        chosen: list[Primitive] = []
        for i in rng.permutation(len(self.candidates)).tolist():
            candidate = self.candidates[i]
            if all(np.hypot(*(candidate.centre - each.centre)) >= APART for each in chosen):
                chosen.append(candidate)
            if len(chosen) == self._primitives:
                break
        return {f'{type(each).__name__.lower()} {i}': each for i, each in enumerate(chosen, 1)}

    def _is_good(self, primitive: Primitive) -> bool:
        low, high = BORDER_SHARE * self._moment.left.shape[1], np.array(self._moment.left.shape[::-1])
        outline = _outline(primitive)
        if (outline < low).any() or (outline > high - low).any() or _shortest_side(primitive) < SIDE_MIN:
            return False
        try:
            points = self._teacher.coordinates(stereo_points([('it', *self._teacher.measure(primitive))]))
        except StereoLandmarkError:
            return False
        return bool(np.linalg.eigvalsh(points.covariances).max() <= self._sigma_max**2)


def _outline(primitive: Primitive) -> NDArray[np.float64]:
    """Return the points of a primitive, shape (n, 2) [px]."""
    return np.array([point.position for point in primitive.image_points().values()])


def _shortest_side(primitive: Primitive) -> float:
    if isinstance(primitive, Corner):
        return float(primitive.arm_lengths.min())
    corners = np.array([p.position for name, p in primitive.image_points().items() if name != 'centre'])
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).min())
