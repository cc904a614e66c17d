"""Localizes the robot at taught places from stereo images (paper 3.4, fig. 6)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereo_landmark.core.arrays import GreyImage
from stereo_landmark.core.landmark_fix import LandmarkFix, NoLandmarkFix, TargetDetection, describe_failure
from stereo_landmark.core.patches.taught_patches import TaughtPatches
from stereo_landmark.core.place.place_locator import PlaceFix, PlaceLocator
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.target_search import TargetSearch
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo import StereoRig, concatenate
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

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
        self._searches = {place.name: TargetSearch(place, self._settings.search) for place in places}
        sigma = self._settings.place.pixel_sigma
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
        failures: list[NoLandmarkFix] = []
        for is_likely in (True, False):
            fixes: list[LandmarkFix] = []
            for place in self.places:
                if (place.name in likely_places) is not is_likely:
                    continue
                # Edges, segments and primitives by the taught parameters (3.3b), once for places with the same ones.
                key = place.processing, frozenset(place.kinds), place.rig
                if key not in views:
                    _check_sizes(place, (left, right))
                    scenes = [detect_scene(image, place.processing, place.kinds) for image in (left, right)]
                    views[key] = StereoView(scenes[0], scenes[1], place.rig, tilt)
                result = self._locate_at(place, views[key])
                if isinstance(result, LandmarkFix):
                    fixes.append(result)
                else:
                    failures.append(result)
            # Of several matching places the most likely one, unless two are about equally likely.
            if fixes:
                return self._select_best(fixes)
        # No place: the reason of the one that came nearest to a fix.
        return max(failures, key=lambda failure: failure.progress)

    def _locate_at(self, place: TaughtPlace, view: StereoView) -> LandmarkFix | NoLandmarkFix:
        # Each target by its procedure tree (figs 7 and 8), and its corresponding points in both images (3.3d).
        detections = tuple(self._searches[place.name].search(target, view) for target in place.targets)
        points = concatenate([each.points for each in detections if isinstance(each, TargetDetection)])
        # Points inside of quadrilaterals again by their texture, with their own taught coordinates.
        measured = self._patches[place.name].measure(points, (view.left.image, view.right.image))
        # The points that were selected for the pose (4c).
        selected = {f'{target.name}/{point}' for target in place.targets for point in target.points}
        is_selected = np.array([name in selected for name in measured.seen.names], dtype=np.bool_)
        # Points at inconsistent distances are excluded (end of 3.4); the others determine the displacement (3.1).
        locator = PlaceLocator(place.rig, self._settings.place)
        result = locator.locate(measured.seen.subset(is_selected), measured.taught, view.tilt)
        if isinstance(result, PlaceFix):
            return LandmarkFix(place, result, detections, measured.matched_patches)
        return describe_failure(place, detections, result)

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
