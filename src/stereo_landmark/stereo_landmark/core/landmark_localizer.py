"""Localizes the robot at taught places from stereo images (paper 3.4, fig. 6)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.landmark_fix import LandmarkFix, NoLandmarkFix, TargetDetection, describe_failure
from stereo_landmark.core.patches.taught_patches import TaughtPatches
from stereo_landmark.core.place.place_locator import PlaceFix, PlaceLocator
from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import ImageProcessing, StereoView, detect_scene
from stereo_landmark.core.procedure.target_search import TargetSearch
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo import StereoPoints, StereoRig, concatenate
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


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
        self._searches = {place.name: TargetSearch(place, self._settings.search) for place in places}
        sigma = self._settings.place.pixel_sigma
        self._patches = {place.name: TaughtPatches(place, sigma) for place in places}

    def locate(
        self,
        left: NDArray[np.uint8],
        right: NDArray[np.uint8],
        tilt: tuple[float, float] = (0.0, 0.0),
        likely_places: Sequence[str] = (),
    ) -> LandmarkFix | NoLandmarkFix:
        """Recognize the place and estimate the displacement from it.

        Args:
            left: rectified grey image of the left camera, shape (h, w).
            right: rectified grey image of the right camera, shape (h, w).
            tilt: known roll and pitch of the base [rad].
            likely_places: names of the places to search first; others are searched only if none of these matches.

        Raises:
            StereoLandmarkError: an image has another type or size than those of the place's cameras.
        """
        likely = [place for place in self.places if place.name in likely_places]
        others = [place for place in self.places if place.name not in likely_places]
        failures: list[NoLandmarkFix] = []
        views = _ViewCache(left, right, tilt)
        for group in (likely, others):
            results = [self._locate_at(place, views.get(place)) for place in group]
            fixes = [result for result in results if isinstance(result, LandmarkFix)]
            if fixes:
                return self._select_best(fixes)
            failures += [result for result in results if isinstance(result, NoLandmarkFix)]
        return max(failures, key=lambda failure: failure.progress)

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

    def _locate_at(self, place: TaughtPlace, view: StereoView) -> LandmarkFix | NoLandmarkFix:
        detections = tuple(self._searches[place.name].search(target, view) for target in place.targets)
        points = concatenate([each.points for each in detections if isinstance(each, TargetDetection)])
        images = view.left.image, view.right.image
        measured = self._patches[place.name].measure(points, images)
        points = measured.seen.subset(_is_pose_point(place, measured.seen))
        result = PlaceLocator(place.rig, self._settings.place).locate(points, measured.taught, view.tilt)
        if isinstance(result, PlaceFix):
            return LandmarkFix(place, result, detections, measured.matched_patches)
        return describe_failure(place, detections, result)


class _ViewCache:
    """Detected primitives of both images, cached for all places with the same image processing.

    Args:
        left: rectified grey image of the left camera, shape (h, w).
        right: rectified grey image of the right camera, shape (h, w).
        tilt: known roll and pitch of the base [rad].
    """

    def __init__(self, left: NDArray[np.uint8], right: NDArray[np.uint8], tilt: tuple[float, float]) -> None:
        self._images = left, right
        self._tilt = tilt
        self._views: dict[tuple[ImageProcessing, frozenset[PrimitiveKind], StereoRig], StereoView] = {}

    def get(self, place: TaughtPlace) -> StereoView:
        """Return the view with the image processing of a place.

        Raises:
            StereoLandmarkError: an image has another type or size than those of the place's cameras.
        """
        key = place.processing, frozenset(place.kinds), place.rig
        if key not in self._views:
            self._check_size(place)
            left, right = (detect_scene(image, place.processing, place.kinds) for image in self._images)
            self._views[key] = StereoView(left, right, place.rig, self._tilt)
        return self._views[key]

    def _check_size(self, place: TaughtPlace) -> None:
        for name, image in zip(('left', 'right'), self._images, strict=True):
            if image.shape != (place.rig.left.height, place.rig.left.width):
                size = 'x'.join(str(side) for side in image.shape[1::-1])
                raise StereoLandmarkError(
                    f'the {name} image is {size}, place {place.name} was taught with '
                    f'{place.rig.left.width}x{place.rig.left.height}; use the same cameras'
                )


def _is_pose_point(place: TaughtPlace, points: StereoPoints) -> NDArray[np.bool_]:
    """Return the mask of the points that were selected for the pose, shape (n,)."""
    pose_points = {f'{target.name}/{point}' for target in place.targets for point in target.points}
    return np.array([name in pose_points for name in points.names], dtype=np.bool_)
