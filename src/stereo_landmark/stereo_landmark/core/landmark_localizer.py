"""Localizes the robot at taught places from stereo images (paper 3.4, fig. 6)."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stereo_landmark.core.arrays import Floats, GreyImage
from stereo_landmark.core.features.feature_search import MeasuredFeatures, SeenImages
from stereo_landmark.core.pair.camera_pair import check_size
from stereo_landmark.core.patches.taught_patches import TaughtPatches
from stereo_landmark.core.place.place_locator import NoPlaceFix, PlaceFix, PlaceLocator
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind
from stereo_landmark.core.procedure.paper_search import PaperSearch
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.target_search import (
    NoTargetDetection,
    TargetDetection,
    TargetResult,
    TargetSearch,
    target_regions,
)
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import CLOSED_FORM, FEATURES, PAPER, SHAPES, LandmarkSettings
from stereo_landmark.core.stereo import StereoRig, TiltedCameras, concatenate
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.view_localizer import (
    LandmarkFix,
    NoLandmarkFix,
    ShapePoints,
    ViewFault,
    ViewLocalizer,
    state_of,
)

__all__ = ['LandmarkFix', 'LandmarkLocalizer', 'NoLandmarkFix']

SHAPES_YAW_MAX = math.radians(20.0)
"""Maximum yaw that is searched by the shapes of a place with features [rad]."""


class PlacePrior(NamedTuple):
    """The place where the robot probably is, and its predicted state there, shape (6,); None if it is unknown."""

    place: str
    state: Floats | None = None


_ViewKey = tuple[ImageProcessing, frozenset[PrimitiveKind], StereoRig]


class LandmarkLocalizer:
    """Localizes the robot at one of its taught places.

    Args:
        places: taught places with unique names.
        settings: localization settings; None for the defaults.

    Raises:
        StereoLandmarkError: there is no place, or two have the same name.
    """

    def __init__(self, places: Sequence[TaughtPlace], settings: LandmarkSettings | None = None) -> None:
        names = [place.name for place in places]
        if not names:
            raise StereoLandmarkError('there is no taught place; teach one')
        for name in names:
            if names.count(name) > 1:
                raise StereoLandmarkError(f'two places are called {name}; names must be unique')
        self.places = tuple(places)
        self._settings = settings or LandmarkSettings()
        search, self._place_settings = self._settings.search, self._settings.place
        self._patches: dict[str, TaughtPatches] = {}
        self._views: dict[str, ViewLocalizer] = {}
        if self._settings.mode == PAPER:
            self._paper_searches = {place.name: PaperSearch(place, search) for place in places}
            self._place_settings = replace(self._place_settings, method=CLOSED_FORM)
        else:
            if self._settings.method != SHAPES:
                self._views = {
                    place.name: ViewLocalizer(place.pair.features, place.rig, self._settings)
                    for place in places
                    if place.pair is not None
                }
            # Beyond this yaw, features find the pose faster than shapes.
            narrow = replace(search, yaw_max=min(search.yaw_max, SHAPES_YAW_MAX))
            self._searches = {
                place.name: TargetSearch(place, narrow if place.name in self._views else search) for place in places
            }
            sigma = self._place_settings.pixel_sigma
            self._patches = {place.name: TaughtPatches(place, sigma) for place in places}

    def locate(
        self, left: GreyImage, right: GreyImage, tilt: tuple[float, float] = (0.0, 0.0), prior: PlacePrior | None = None
    ) -> LandmarkFix | NoLandmarkFix:
        """Recognize the place and estimate the displacement from it (paper 3.4, fig. 6).

        Args:
            left: rectified grey image of the left camera, shape (h, w).
            right: rectified grey image of the right camera, shape (h, w).
            tilt: known roll and pitch of the base [rad].
            prior: the place to search first; others are searched only if it does not match. At its predicted pose,
                features are measured without a search.

        Raises:
            StereoLandmarkError: an image has another type or size than those of the place's cameras.
        """
        views: dict[_ViewKey, StereoView] = {}
        seen = SeenImages(left, right)
        failures: list[NoLandmarkFix] = []
        for is_likely in (True, False):
            fixes: list[LandmarkFix] = []
            for place in self.places:
                if (prior is not None and place.name == prior.place) is not is_likely:
                    continue
                check_size(left, place.rig.left, 'the left image')
                check_size(right, place.rig.right, 'the right image')
                predicted = prior.state if prior is not None and is_likely else None
                result = self._locate_at(place, seen, tilt, views, predicted)
                if isinstance(result, LandmarkFix):
                    fixes.append(result)
                else:
                    failures.append(result)
            # Of several matching places the most likely one, unless two are about equally likely.
            if fixes:
                return self._select_best(fixes)
        # No place: the reason of the one that came nearest to a fix.
        return max(failures, key=lambda failure: failure.progress)

    def _locate_at(
        self,
        place: TaughtPlace,
        images: SeenImages,
        tilt: tuple[float, float],
        views: dict[_ViewKey, StereoView],
        predicted: Floats | None,
    ) -> LandmarkFix | NoLandmarkFix:
        """Return the pose at a place: features find it, else shapes, and the fit uses both."""
        view, by_shapes = self._views.get(place.name), self._settings.method != FEATURES
        # 1. Without features: the paper's search.
        if view is None:
            return self._locate_by_shapes(place, images, tilt, views)[0]
        # 2. Features where the prior predicts them; else features of the whole image.
        followed = None if predicted is None else view.confirm(predicted, images)
        found = (predicted, followed) if predicted is not None and followed is not None else view.find(images, tilt)
        # 3. Shapes where the pose predicts them; all points into one fit.
        if not isinstance(found, ViewFault):
            result = self._fit_at(place, view, found, images, tilt)
            if result is not None:
                return result
            found = ViewFault.NOT_FOUND
        # 4. Where features do not find a unique pose: the paper's search, which the features have to confirm.
        if not by_shapes:
            return NoLandmarkFix(found.value, f'place {place.name}')
        fix, points = self._locate_by_shapes(place, images, tilt, views)
        if not isinstance(fix, LandmarkFix):
            return self._finish(place, found, fix.detections) if found is ViewFault.AMBIGUOUS else fix
        confirmed = view.confirm(state_of(fix.displacement), images)
        if confirmed is None:
            is_free = found is ViewFault.NOT_FOUND and view.is_sparse
            return fix if is_free else self._finish(place, found, fix.detections)
        used = np.array([name in fix.displacement.names for name in points.seen.names], dtype=np.bool_)
        points = ShapePoints(points.seen.subset(used), points.taught)
        joint = view.fit(state_of(fix.displacement), confirmed, points, tilt)
        return self._finish(place, joint, fix.detections, fix.matched_patches)

    def _fit_at(
        self,
        place: TaughtPlace,
        view: ViewLocalizer,
        found: tuple[Floats, MeasuredFeatures],
        images: SeenImages,
        tilt: tuple[float, float],
    ) -> LandmarkFix | NoLandmarkFix | None:
        """Return the pose near one that features found; None if they do not determine it."""
        start, measured = found
        state = view.refine(start, measured, tilt)
        if state is None:
            return None
        detections = self._detect_at(place, images, state) if self._settings.method != FEATURES else ()
        points, patches = self._measure(place, detections, images)
        return self._finish(place, view.fit(state, measured, points, tilt), detections, patches)

    def _finish(
        self,
        place: TaughtPlace,
        result: PlaceFix | ViewFault,
        detections: tuple[TargetResult, ...],
        patches: tuple[str, ...] = (),
    ) -> LandmarkFix | NoLandmarkFix:
        if isinstance(result, PlaceFix):
            return LandmarkFix(place, result, detections, patches)
        return NoLandmarkFix(result.value, f'place {place.name}', detections)

    def _detect(
        self, place: TaughtPlace, images: SeenImages, tilt: tuple[float, float], views: dict[_ViewKey, StereoView]
    ) -> tuple[TargetResult, ...]:
        """Search each target by its procedure tree (figs 7 and 8)."""
        if self._settings.mode == PAPER:
            pair = images.left, images.right
            return tuple(self._paper_searches[place.name].search(target, pair, tilt) for target in place.targets)
        detections = []
        for target in place.targets:
            # Edges, segments and primitives by the taught parameters (3.3b), once for targets with the same ones.
            processing = target.processing or place.processing
            key = processing, frozenset(place.kinds), place.rig
            if key not in views:
                scenes = [detect_scene(image, processing, place.kinds) for image in (images.left, images.right)]
                views[key] = StereoView(scenes[0], scenes[1], place.rig, tilt)
            detections.append(self._searches[place.name].search(target, views[key]))
        return tuple(detections)

    def _detect_at(self, place: TaughtPlace, images: SeenImages, state: Floats) -> tuple[TargetResult, ...]:
        """Search each target where a state, shape (6,), predicts it; the images are processed only there."""
        detections = []
        for target in place.targets:
            kinds = {primitive.kind for primitive in target.primitives}
            cameras = TiltedCameras(place.rig, (state[4], state[5]))
            scenes = [
                detect_scene(image, target.processing or place.processing, kinds, region)
                for image, region in zip(
                    (images.left, images.right), target_regions(target, cameras, state[:4]), strict=True
                )
            ]
            view = StereoView(scenes[0], scenes[1], place.rig, cameras.tilt)
            detections.append(self._searches[place.name].search_at(target, view, state[:4]))
        return tuple(detections)

    def _measure(
        self, place: TaughtPlace, detections: tuple[TargetResult, ...], images: SeenImages
    ) -> tuple[ShapePoints, tuple[str, ...]]:
        """Return the points that were selected for the pose (4c), and the names of the patches that measure them."""
        # The corresponding points of the targets in both images (3.3d).
        seen = concatenate([each.points for each in detections if isinstance(each, TargetDetection)])
        taught = place.coordinates
        patches: tuple[str, ...] = ()
        if place.name in self._patches:
            # Points inside of quadrilaterals again by their texture, with their own taught coordinates.
            seen, taught, patches = self._patches[place.name].measure(seen, (images.left, images.right))
        selected = {f'{target.name}/{point}' for target in place.targets for point in target.points}
        is_selected = np.array([name in selected for name in seen.names], dtype=np.bool_)
        return ShapePoints(seen.subset(is_selected), taught), patches

    def _locate_by_shapes(
        self, place: TaughtPlace, images: SeenImages, tilt: tuple[float, float], views: dict[_ViewKey, StereoView]
    ) -> tuple[LandmarkFix | NoLandmarkFix, ShapePoints]:
        detections = self._detect(place, images, tilt, views)
        points, patches = self._measure(place, detections, images)
        # Points at inconsistent distances are excluded (end of 3.4); the others determine the displacement (3.1).
        result = PlaceLocator(place.rig, self._place_settings).locate(*points, tilt)
        if isinstance(result, PlaceFix):
            return LandmarkFix(place, result, detections, patches), points
        return _describe_failure(place, detections, result), points

    def _select_best(self, fixes: list[LandmarkFix]) -> LandmarkFix | NoLandmarkFix:
        """Return the fix with the highest log-likelihood ratio, unless it is ambiguous."""
        fixes.sort(key=lambda fix: -fix.log_likelihood_ratio)
        margin = self._settings.search.margin
        if len(fixes) > 1 and fixes[0].log_likelihood_ratio - fixes[1].log_likelihood_ratio < margin:
            names = ' and '.join(fix.place.name for fix in fixes[:2])
            return NoLandmarkFix(
                'ambiguous: several places match', f'places {names} have similar scores', fixes[0].detections
            )
        return fixes[0]


def _describe_failure(place: TaughtPlace, detections: tuple[TargetResult, ...], fault: NoPlaceFix) -> NoLandmarkFix:
    """Return why a place gave no pose: the points of its targets were rejected, or no target was detected."""
    missing = [each for each in detections if isinstance(each, NoTargetDetection)]
    if len(missing) < len(detections):
        return NoLandmarkFix(fault.reason.value, f'place {place.name}: {fault.detail}', detections)
    reason = missing[0].reason.value
    detail = '; '.join(f'{each.target}: {each.reason.value} ({each.detail})' for each in missing)
    return NoLandmarkFix(reason, f'place {place.name}: {detail}', detections)
