"""``shirube try floor``: would the localizer find its place on this floor, from which height, and how exactly?

A map is made of the first photograph, with the detector of the product, at the scale of the robot's camera. Views of
that camera are cut out of the other photographs of the same area, which are registered to the first by their features,
and located in the map without a prior.
"""

import argparse
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import cycle, islice
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.dots import DotMap
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.settings import DotDetectorSettings, LocalizerSettings
from shirube_cli.suitability.pictures import Image, grey, parse, read_film
from shirube_cli.suitability.scale import find_card, find_coin
from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from stereo_landmark.core.features.taught_features import detect_features, match_features

Array = NDArray[np.float64]
_VIEWS = (0.06, 0.09, 0.12, 0.16, 0.22, 0.30)  # sides of the views that are tried [m]
_TRIALS, _DOTS_MIN = 40, 10
_OUTLINE_MARGIN = 3.0  # of the card [px]
_FOUND_MIN = 0.9  # of the views, and none wrong
_PLACES = 200  # tried for a view that fits into both photographs
_AGREEMENT = 0.002  # of a right pose with the registration [m]
_VIEW_MAX = 0.4  # of the photograph, so that different views fit into it
_ENLARGED_MAX = 2.0  # a photograph to the scale of the camera
_SCALE_ERROR, _NOISE, _GAIN, _GRADIENT = 0.02, 4.0, (0.6, 1.15), 0.15  # of a view, as in real_photographs
_FRAMES = 9  # of a film
_REGISTERED_SIDE = 1600  # of a photograph in which features are searched [px]
_INLIERS_MIN, _INLIER_DISTANCE = 40, 3.0  # [-, px]
_TURN_MIN, _SHIFT_MIN = math.radians(10.0), 0.15  # to another photograph [rad, of the width]
_COPY_CORRELATION = 0.98  # of the finest details, above which one photograph is a copy of the other


class Photograph(NamedTuple):
    """A photograph, shape (h, w, 3), and the homography from pixels of the first photograph to its own."""

    image: Image
    homography: Array

    def resized(self, scale: float) -> 'Photograph':
        """Return it in another size, relative to its own."""
        size = [max(round(scale * side), 1) for side in self.image.shape[1::-1]]
        image = cv2.resize(self.image, size, interpolation=cv2.INTER_AREA if scale < 1.0 else cv2.INTER_CUBIC)
        factors = np.array([*size, 1.0]) / (*self.image.shape[1::-1], 1.0)
        resize = np.diag(factors)
        resize[:2, 2] = 0.5 * factors[:2] - 0.5  # the origin is the centre of a pixel
        return Photograph(np.asarray(image, np.uint8), resize @ self.homography)

    def jacobian(self, middle: Array) -> Array:
        """Return the derivative of its pixels by those of the first photograph at a pixel of that."""
        around = _transform(self.homography, middle + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
        return np.asarray((around[1:] - around[0]).T, np.float64)


@dataclass(frozen=True)
class ViewVerdict:
    """What became of views of one side [m]: mean number of dots, errors of located views [m], number of views."""

    side: float
    height: float
    dots: float
    errors: Array
    views: int

    @property
    def wrong(self) -> int:
        """Number of wrong poses."""
        return int(np.count_nonzero(self.errors > _AGREEMENT))

    @property
    def is_good(self) -> bool:
        """Whether nearly all views are located, and none wrongly."""
        return not self.wrong and len(self.errors) >= _FOUND_MIN * self.views and self.views >= _TRIALS // 2


def register(first: Image, other: Image) -> Photograph | None:
    """Return another photograph of the same area with its homography, None if they have too little in common."""
    here, there = (
        Photograph(each, np.eye(3)).resized(min(_REGISTERED_SIDE / max(each.shape), 1.0)) for each in (first, other)
    )
    greys = grey(here.image), grey(there.image)
    of_first, of_other = (detect_features(each) for each in greys)
    pairs = match_features(of_first, of_other)
    if len(pairs) < _INLIERS_MIN:
        return None
    pixels = of_first.pixels[pairs[:, 0]], of_other.pixels[pairs[:, 1]]
    found, inliers = cv2.findHomography(pixels[0], pixels[1], cv2.RANSAC, _INLIER_DISTANCE)
    if found is None or inliers.sum() < _INLIERS_MIN:
        return None
    found = _refine(*greys, np.asarray(found))
    return Photograph(other, np.linalg.inv(there.homography) @ found @ here.homography)


def _refine(first: Image, other: Image, homography: Array) -> Array:
    """Align grey pictures by their grey levels; features have a bias of half a pixel."""
    criteria, inverse = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-6), np.linalg.inv(homography)
    back, seen = (cv2.warpPerspective(e, inverse, first.shape[::-1]) for e in (other, np.full_like(other, 255)))
    start = np.eye(3, dtype=np.float32)
    try:
        _, left = cv2.findTransformECC(first, back, start, cv2.MOTION_HOMOGRAPHY, criteria, seen, 5)
    except cv2.error:  # it does not converge
        return homography
    return homography @ left


def is_same(first: Image, other: Photograph) -> bool:
    """Return whether a registered photograph was taken from about the same place, or is a copy."""
    size, inverse = np.array(first.shape[1::-1]), np.linalg.inv(other.homography)
    (a, b), (c, d) = other.jacobian(0.5 * size)
    shift = _transform(inverse, 0.5 * np.array([other.image.shape[1::-1]]))[0] - 0.5 * size
    is_near = abs(math.atan2(c - b, a + d)) < _TURN_MIN and float(np.hypot(*shift)) < _SHIFT_MIN * size[0]
    back = np.asarray(cv2.warpPerspective(other.image, inverse, size.tolist()), np.uint8)
    levels = [grey(each).astype(np.float32) for each in (first, back)]
    fine = [(each - cv2.GaussianBlur(each, (0, 0), 2.0))[back.any(axis=2)] for each in levels]
    return is_near or bool(np.corrcoef(*fine)[0, 1] > _COPY_CORRELATION)


def _transform(homography: NDArray[np.floating[Any]], points: Array) -> Array:
    moved = np.column_stack([points, np.ones(len(points))]) @ homography.T
    return np.asarray(moved[:, :2] / moved[:, 2:], np.float64)


class FloorTrial:
    """The map of a photograph of this scale [m/px], and views of one side [m] to locate in it.

    What is inside the outline of the card or coin is ignored.
    """

    def __init__(
        self, first: Image, scale: float, outline: NDArray[np.int32] | None, side: float, options: argparse.Namespace
    ) -> None:
        self._size, self._scale, self._side, self._outline = np.array(first.shape[1::-1]), scale, side, outline
        half, pixels = 0.5 / math.tan(0.5 * math.radians(options.fov)), options.pixels
        self._metres, self._height, middle = side / pixels, half * side, 0.5 * (pixels - 1)
        self._camera = PinholeCamera(pixels, pixels, half * pixels, half * pixels, middle, middle)
        mount = CameraMount((0.0, 0.0, self._height))
        grid = np.stack(np.meshgrid(np.arange(pixels), np.arange(pixels)), axis=-1).reshape(-1, 2)
        self._floor = mount.floor_points_from_rays(self._camera.rays_from_pixels(grid.astype(np.float64)))
        largest = DotDetectorSettings().largest_diameter(pixels, pixels)  # as in the images of the robot's camera
        detector = DotDetector(DotDetectorSettings(maximum_diameter=largest))
        resized = Photograph(first, np.eye(3)).resized(scale / self._metres)
        found = _transform(np.linalg.inv(resized.homography), detector.detect(resized.image).pixels)
        points = found[[not self._is_ignored(point, 0.0) for point in found]] * (scale, -scale)
        self.density = len(points) / float(np.prod(self._size * scale))
        self._localizer = None
        if len(points) >= _DOTS_MIN:
            floor = index_map(DotMap(points, np.full(len(points), np.nan)))
            self._localizer = FloorLocalizer(floor, mount, None, detector)
            # The whole floor has more dots for a wrong match than the photograph.
            factor = max(options.area * self.density / len(points), 1.0)
            self._chance_max = LocalizerSettings.chance_alignments_max / factor

    def _is_ignored(self, pixel: Array, reach: float) -> bool:
        u, v = pixel.tolist()
        return self._outline is not None and bool(
            cv2.pointPolygonTest(self._outline, (u, v), True) > -reach / self._scale - _OUTLINE_MARGIN
        )

    def run(self, others: Sequence[Photograph], generator: np.random.Generator) -> ViewVerdict:
        """Locate views of the other photographs."""
        counts, errors = list[int](), list[float]()
        for other in islice(cycle(others), _TRIALS if self._localizer else 0):
            drawn = self._cut(other, generator)
            if drawn is None or self._localizer is None:
                continue
            dots = self._localizer.detect(drawn[0])
            counts.append(len(dots))
            fix = self._localizer.locate_dots(dots, self._camera)
            if isinstance(fix, Fix) and fix.expected_chance_alignments < self._chance_max:
                errors.append(fix.T_map_base.distance_to(drawn[1]))
        return ViewVerdict(self._side, self._height, float(np.mean(counts or 0.0)), np.array(errors), len(counts))

    def _cut(self, other: Photograph, generator: np.random.Generator) -> tuple[Image, SE2] | None:
        """Return a view of the robot's camera and its pose; None if it does not fit into both photographs."""
        stretch = math.sqrt(abs(float(np.linalg.det(other.jacobian(0.5 * self._size)))))
        other = other.resized(self._scale / stretch / self._metres)
        for _ in range(_PLACES):
            u, v = generator.uniform(0.0, self._size).tolist()
            pose = SE2(self._scale * u, -self._scale * v, generator.uniform(-math.pi, math.pi))
            if self._is_ignored(np.array([u, v]), self._side / math.sqrt(2.0)):
                continue
            points = (1.0 + generator.uniform(-_SCALE_ERROR, _SCALE_ERROR)) * self._floor
            side = self._camera.width
            first = pose.transform(points[[0, side - 1, -side, -1]]) / (self._scale, -self._scale)
            bounds = (first, self._size), (_transform(other.homography, first), other.image.shape[1::-1])
            if all(((each > 0.0) & (each < np.array(size) - 1.0)).all() for each, size in bounds):
                pixels = _transform(other.homography, pose.transform(points) / (self._scale, -self._scale))
                return self._expose(other.image, pixels, generator), pose
        return None

    def _expose(self, image: Image, pixels: Array, generator: np.random.Generator) -> Image:
        """Return the view, unevenly lit and with noise."""
        side = self._camera.width
        u, v = np.moveaxis(pixels.astype(np.float32).reshape(side, side, 2), 2, 0)
        slope, (along, across) = np.linspace(-1.0, 1.0, side), generator.uniform(-_GRADIENT, _GRADIENT, 2)
        light = generator.uniform(*_GAIN) * (1.0 + along * slope + across * slope[:, None])
        seen = light[..., None] * cv2.remap(image, u, v, cv2.INTER_CUBIC)
        return np.clip(np.round(seen + generator.normal(0.0, _NOISE, seen.shape)), 0, 255).astype(np.uint8)


def try_floor(arguments: Sequence[str]) -> int:
    """Print what a photographed floor is worth; return 0 if it suits, or else 1."""
    options = parse(_parser(), arguments, 'floor_localizer')
    pictures = [picture for path in options.photos for picture in read_film(path, _FRAMES, spread=True).pictures]
    first, outline, scale = pictures[0], None, options.mm_per_pixel
    if scale is None:
        scale, outline = find_card(first) if options.coin is None else find_coin(first, options.coin)
    registered = [each for picture in pictures[1:] if (each := register(first, picture)) is not None]
    others = [each for each in registered if not is_same(first, each)]
    height, width = (1e-3 * scale * side for side in first.shape[:2])
    print(f'first photograph   {scale:.3f} mm/px, {1e3 * width:.0f} x {1e3 * height:.0f} mm of floor')
    print(f'other photographs  {len(pictures) - 1}, of which {len(registered)} show the same area, '
          f'{len(others)} of them turned or moved')  # fmt: skip
    print('view mm  height mm  dots/m²  dots in view  found  wrong  of  error mm: median, 95 %')
    verdicts = []
    for side in _VIEWS:
        if 1e-3 * scale * options.pixels / _ENLARGED_MAX <= side <= _VIEW_MAX * min(width, height):
            trial = FloorTrial(first, 1e-3 * scale, outline, side, options)
            seen = trial.run(others or [Photograph(first, np.eye(3))], np.random.default_rng(0))
            verdicts.append(seen)
            is_measured = others and len(seen.errors)
            error = '{:.2f}, {:.2f}'.format(*np.quantile(1e3 * seen.errors, (0.5, 0.95))) if is_measured else '-'
            print(f'{1e3 * side:7.0f}  {1e3 * seen.height:9.0f}  {trial.density:7.0f}  {seen.dots:12.0f}  '
                  f'{len(seen.errors) - seen.wrong:5d}  {seen.wrong:5d}  {seen.views:2d}  {error}')  # fmt: skip
    print(*_conclude(verdicts, len(pictures), is_sure=bool(others)), sep='\n')
    return int(not others or not any(each.is_good for each in verdicts))


def _conclude(verdicts: Sequence[ViewVerdict], count: int, *, is_sure: bool) -> Iterator[str]:
    """Yield the verdict with its remedy."""
    good = [each for each in verdicts if each.is_good]
    if not good:
        why = f'no tried view is located in {100.0 * _FOUND_MIN:.0f} % of its places'
        if not any(each.dots for each in verdicts):
            why = 'the photographs have no dots, or show too little of the same floor in too few pixels'
        elif any(each.wrong for each in verdicts):
            why = 'views are located at wrong places: the pattern repeats, or a photograph is oblique'
        yield f'This floor does not suit: {why}.'
        yield 'Photograph a larger area in even light, or lay a mat: shirube run floor_localizer print_mat'
        return
    views = ', '.join(f'{1e3 * each.side:.0f} mm from a height of {1e3 * each.height:.0f} mm' for each in good)
    yield f'This floor {"suits" if is_sure else "possibly suits"}, with a view of {views}.'
    if is_sure:
        yield 'The error is that of the dots; mount, tilt and map add to it. Not seen: wear, dirt, repeats elsewhere.'
        return
    yield (
        'One photograph does not show whether the dots are found again.'
        if count == 1
        else ('The other photographs do not show the same area a second time.')
    )
    yield 'For a verdict, photograph this area again, turned by a quarter and in other light; give both photographs.'


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='shirube try floor',
        description='Judge a floor by two or more photographs of one area, turned and in other light, or by a film; '
        'each from straight above. The first one shows the scale.',
    )
    add = parser.add_argument
    add('photos', nargs='+', type=Path, metavar='FILE', help='photograph or film')
    scale = parser.add_mutually_exclusive_group()
    scale.add_argument('--card', action='store_true', help='a bank card lies on the floor (default)')
    scale.add_argument('--coin', type=float, metavar='MM', help='a coin of this diameter lies on the floor')
    scale.add_argument('--mm-per-pixel', type=float, metavar='MM', help='scale of the first photograph, by a ruler')
    add('--area', type=float, default=100.0, help='of the whole floor [m²] (default: %(default)s)')
    add('--fov', type=float, default=38.2, help="of the robot's camera, short side [deg] (default: %(default)s)")
    add('--pixels', type=int, default=235, help='of its short side that the node gets (default: %(default)s)')
    return parser
