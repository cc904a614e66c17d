"""Localizes the robot at taught places from stereo images (paper 3.4, fig. 6)."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stereo_landmark.core.arrays import Floats, GreyImage
from stereo_landmark.core.features.feature_search import SeenImages
from stereo_landmark.core.patches.taught_patches import TaughtPatches
from stereo_landmark.core.place.place_locator import NoPlaceFix, PlaceFix, PlaceLocator
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind
from stereo_landmark.core.procedure.paper_search import PaperSearch
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.target_search import NoTargetDetection, TargetDetection, TargetResult, TargetSearch
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import BOTH, CLOSED_FORM, PAPER, SHAPES, LandmarkSettings
from stereo_landmark.core.stereo import StereoRig, concatenate
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
        self,
        left: GreyImage,
        right: GreyImage,
        tilt: tuple[float, float] = (0.0, 0.0),
        likely_places: Sequence[str] = (),
    ) -> LandmarkFix | NoLandmarkFix:
        """Recognize the place and estimate the displacement from it (paper 3.4, fig. 6).

        Args:
            left: rectified grey image of the left camera, shape (h, w).
            right: rectified grey image of the right camera, shape (h, w).
            tilt: known roll and pitch of the base [rad].
            likely_places: names of the places to search first; others are searched only if none of these matches.

        Raises:
            StereoLandmarkError: an image has another type or size than those of the place's cameras.
        """
        views: dict[_ViewKey, StereoView] = {}
        seen = SeenImages(left, right)
        failures: list[NoLandmarkFix] = []
        for is_likely in (True, False):
            fixes: list[LandmarkFix] = []
            for place in self.places:
                if (place.name in likely_places) is not is_likely:
                    continue
                _check_sizes(place, (left, right))
                result = self._locate_at(place, seen, tilt, views)
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
        self, place: TaughtPlace, images: SeenImages, tilt: tuple[float, float], views: dict[_ViewKey, StereoView]
    ) -> LandmarkFix | NoLandmarkFix:
        """Return the pose at a place: shapes find it, else features, and the fit uses both."""
        view = self._views.get(place.name)
        by_shapes: LandmarkFix | NoLandmarkFix = NoLandmarkFix(ViewFault.NOT_FOUND.value, f'place {place.name}')
        if view is None or self._settings.method == BOTH:
            detections = self._detect(place, images, tilt, views)
            by_shapes, points = self._locate_by_shapes(place, detections, images, tilt)
        if view is None:
            return by_shapes
        shape_fix = by_shapes.displacement if isinstance(by_shapes, LandmarkFix) else None
        confirmed = None if shape_fix is None else view.confirm(shape_fix, images)
        if isinstance(by_shapes, LandmarkFix) and confirmed is not None:
            used = np.array([name in by_shapes.displacement.names for name in points.seen.names], dtype=np.bool_)
            points = ShapePoints(points.seen.subset(used), points.taught)
            fix = view.fit(state_of(by_shapes.displacement), confirmed, points, tilt)
            return self._finish(place, fix, by_shapes.detections, by_shapes.matched_patches)
        found = view.find(images, tilt, shape_fix)
        if isinstance(found, ViewFault):
            if found is ViewFault.NOT_FOUND and (shape_fix is None or view.is_sparse):
                return by_shapes
            return self._finish(place, found, by_shapes.detections)
        state, measured = found
        detections = ()
        if self._settings.method == BOTH:
            level = state[4], state[5]
            detections = self._detect(place, images, level, views, state[:4])
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
        self,
        place: TaughtPlace,
        images: SeenImages,
        tilt: tuple[float, float],
        views: dict[_ViewKey, StereoView],
        state: Floats | None = None,
    ) -> tuple[TargetResult, ...]:
        """Search each target by its procedure tree (figs 7 and 8), or at a known state, shape (4,)."""
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
            search = self._searches[place.name]
            if state is None:
                detections.append(search.search(target, views[key]))
            else:
                detections.append(search.search_at(target, replace(views[key], tilt=tilt), state))
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
        self, place: TaughtPlace, detections: tuple[TargetResult, ...], images: SeenImages, tilt: tuple[float, float]
    ) -> tuple[LandmarkFix | NoLandmarkFix, ShapePoints]:
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


def _check_sizes(place: TaughtPlace, images: tuple[GreyImage, GreyImage]) -> None:
    for name, image in zip(('left', 'right'), images, strict=True):
        if image.shape != (place.rig.left.height, place.rig.left.width):
            size = 'x'.join(str(side) for side in image.shape[1::-1])
            raise StereoLandmarkError(
                f'the {name} image is {size}, place {place.name} was taught with '
                f'{place.rig.left.width}x{place.rig.left.height}; use the same cameras'
            )


def _describe_failure(place: TaughtPlace, detections: tuple[TargetResult, ...], fault: NoPlaceFix) -> NoLandmarkFix:
    """Return why a place gave no pose: the points of its targets were rejected, or no target was detected."""
    missing = [each for each in detections if isinstance(each, NoTargetDetection)]
    if len(missing) < len(detections):
        return NoLandmarkFix(fault.reason.value, f'place {place.name}: {fault.detail}', detections)
    reason = missing[0].reason.value
    detail = '; '.join(f'{each.target}: {each.reason.value} ({each.detail})' for each in missing)
    return NoLandmarkFix(reason, f'place {place.name}: {detail}', detections)
