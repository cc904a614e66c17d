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
from stereo_landmark.core.features.image_features import detect_features, match_features

Array = NDArray[np.float64]
_VIEWS = (0.06, 0.09, 0.12, 0.16, 0.22, 0.30)  # sides of the views that are tried [m]
_TRIALS = 40
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


@dataclass(frozen=True)
class Photograph:
    """A photograph of the floor.

    Attributes:
        image: shape (h, w, 3).
        homography: shape (3, 3), from pixels of the first photograph to its own.
    """

    image: Image
    homography: Array

    def resized(self, scale: float) -> 'Photograph':
        """Return it in another size, relative to its own."""
        size = [max(round(scale * side), 1) for side in self.image.shape[1::-1]]
        method = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_CUBIC
        shift = 0.5 * scale - 0.5  # the origin is the centre of a pixel
        resize = np.array([[scale, 0.0, shift], [0.0, scale, shift], [0.0, 0.0, 1.0]])
        return Photograph(np.asarray(cv2.resize(self.image, size, interpolation=method)), resize @ self.homography)

    def jacobian(self, shape: tuple[int, ...]) -> Array:
        """Return the derivative of its pixels by those of the first photograph, in the middle of that."""
        u, v = 0.5 * shape[1], 0.5 * shape[0]
        corners = _transform(self.homography, np.array([[u, v], [u + 1.0, v], [u, v + 1.0]]))
        return (corners[1:] - corners[0]).T


@dataclass(frozen=True)
class ViewVerdict:
    """What became of views of one size.

    Attributes:
        side: side of the square of floor in view [m].
        height: of the camera [m].
        dots: mean number of dots in view.
        errors: of the views that are located [m].
        views: number of views.
    """

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
    def found(self) -> int:
        """Number of right poses."""
        return len(self.errors) - self.wrong

    @property
    def is_good(self) -> bool:
        """Whether nearly all views are located, and none wrongly."""
        return not self.wrong and self.found >= _FOUND_MIN * self.views and self.views >= _TRIALS // 2


def register(first: Image, other: Image) -> Photograph | None:
    """Return another photograph of the same area with its homography, None if they have too little in common."""
    scales = [min(_REGISTERED_SIDE / max(each.shape), 1.0) for each in (first, other)]
    small = [Photograph(each, np.eye(3)).resized(scale) for each, scale in zip((first, other), scales, strict=True)]
    here, there = (detect_features(grey(each.image)) for each in small)
    pairs = match_features(here, there)
    if len(pairs) < _INLIERS_MIN:
        return None
    found, inliers = cv2.findHomography(here.pixels[pairs[:, 0]], there.pixels[pairs[:, 1]], 8, _INLIER_DISTANCE)
    if found is None or inliers.sum() < _INLIERS_MIN:
        return None
    found = _refine(*(grey(each.image) for each in small), found)
    return Photograph(other, np.linalg.inv(small[1].homography) @ found @ small[0].homography)


def _refine(first: Image, other: Image, homography: Array) -> Array:
    """Align grey pictures by their grey levels; features have a bias of half a pixel."""
    criteria, size = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-6), first.shape[::-1]
    back, seen = (
        cv2.warpPerspective(each, homography, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
        for each in (other, np.full_like(other, 255))
    )
    start = np.eye(3, dtype=np.float32)
    try:
        _, left = cv2.findTransformECC(first, back, start, cv2.MOTION_HOMOGRAPHY, criteria, seen, 5)
    except cv2.error:  # it does not converge
        return homography
    return homography @ left


def is_same(first: Image, other: Photograph) -> bool:
    """Return whether a registered photograph was taken from about the same place, or is a copy."""
    (a, b), (c, d) = other.jacobian(first.shape)
    height, width = first.shape[:2]
    middle = np.array([[0.5 * width, 0.5 * height]])
    shift = _transform(np.linalg.inv(other.homography), 0.5 * np.array([other.image.shape[1::-1]])) - middle
    is_near = abs(math.atan2(c - b, a + d)) < _TURN_MIN and float(np.linalg.norm(shift)) < _SHIFT_MIN * width
    back = np.asarray(cv2.warpPerspective(other.image, np.linalg.inv(other.homography), (width, height)), np.uint8)
    fine = [cv2.subtract(level := grey(each).astype(np.float32), cv2.blur(level, (5, 5))) for each in (first, back)]
    correlation = np.corrcoef(*(each[back.any(axis=2)] for each in fine))[0, 1]
    return is_near or bool(correlation > _COPY_CORRELATION)


def _transform(homography: Array, points: Array) -> Array:
    moved = np.column_stack([points, np.ones(len(points))]) @ homography.T
    return np.asarray(moved[:, :2] / moved[:, 2:])


class FloorTrial:
    """The map of a photograph, and views of one size to locate in it.

    Args:
        first: first photograph, shape (h, w, 3).
        scale: its scale [m/px].
        ignored: outline of the card or coin in it [px].
        side: side of the views [m].
        options: of the command.
    """

    def __init__(
        self, first: Image, scale: float, ignored: NDArray[np.int32] | None, side: float, options: argparse.Namespace
    ) -> None:
        self._shape, self._scale, self._side, self._ignored = first.shape, scale, side, ignored
        half, pixels = 0.5 / math.tan(0.5 * math.radians(options.fov)), options.pixels
        self._metres, self.height = side / pixels, half * side
        self._camera = PinholeCamera(pixels, pixels, half * pixels, half * pixels, *[0.5 * (pixels - 1)] * 2)
        mount = CameraMount((0.0, 0.0, self.height))
        grid = np.stack(np.meshgrid(np.arange(pixels), np.arange(pixels)), axis=-1).reshape(-1, 2)
        self._floor = mount.floor_points_from_rays(self._camera.rays_from_pixels(grid.astype(np.float64)))
        detector = DotDetector(
            DotDetectorSettings(maximum_diameter=DotDetectorSettings().largest_diameter(pixels, pixels))
        )
        resized = Photograph(first, np.eye(3)).resized(scale / self._metres)
        points = self._metric(_transform(np.linalg.inv(resized.homography), detector.detect(resized.image).pixels))
        points = points[[not self._is_ignored(point, 0.0) for point in points]]
        self.density = len(points) / (np.prod(first.shape[:2]) * scale**2)
        self._localizer, self._odds = None, 1.0
        if len(points) > 10:
            floor = index_map(DotMap(points, np.full(len(points), np.nan)))
            self._localizer = FloorLocalizer(floor, mount, None, detector)
            # The whole floor has more dots for a wrong match than the photograph.
            self._odds = max(options.area * self.density / len(points), 1.0)

    def _metric(self, pixels: Array) -> Array:
        return pixels.reshape(-1, 2) * (self._scale, -self._scale)

    def _pixels(self, points: Array) -> Array:
        return points / (self._scale, -self._scale)

    def _is_ignored(self, point: Array, margin: float) -> bool:
        if self._ignored is None:
            return False
        u, v = self._pixels(point).tolist()
        return cv2.pointPolygonTest(self._ignored, (u, v), True) > -margin / self._scale - 3.0

    def run(self, others: Sequence[Photograph], generator: np.random.Generator) -> ViewVerdict:
        """Locate views of the other photographs."""
        counts, errors, views = [], [], 0
        for other in islice(cycle(others), _TRIALS if self._localizer else 0):
            drawn = self._cut(other, generator)
            if drawn is None or self._localizer is None:
                continue
            dots, pose = self._localizer.detect(drawn[0]), drawn[1]
            fix = self._localizer.locate_dots(dots, self._camera)
            views, counts = views + 1, [*counts, len(dots)]
            if (
                isinstance(fix, Fix)
                and fix.expected_chance_alignments * self._odds < LocalizerSettings.chance_alignments_max
            ):
                errors.append(fix.T_map_base.distance_to(pose))
        return ViewVerdict(self._side, self.height, float(np.mean(counts or 0.0)), np.array(errors), views)

    def _cut(self, other: Photograph, generator: np.random.Generator) -> tuple[Image, SE2] | None:
        """Return a view of the robot's camera and its pose; None if it does not fit into both photographs."""
        reach = 0.5 * math.sqrt(2.0) * self._side * (1.0 + _SCALE_ERROR)
        stretch = math.sqrt(abs(float(np.linalg.det(other.jacobian(self._shape)))))
        other = other.resized(self._scale / stretch / self._metres)
        for _ in range(_PLACES):
            x, y = self._metric(generator.uniform(0.0, self._shape[1::-1]))[0].tolist()
            pose = SE2(x, y, generator.uniform(-math.pi, math.pi))
            points = pose.transform((1.0 + generator.uniform(-_SCALE_ERROR, _SCALE_ERROR)) * self._floor)
            first = self._pixels(points)
            pixels = _transform(other.homography, first)
            inside = [
                ((each > 0) & (each < np.array(shape[1::-1]) - 1.0)).all()
                for each, shape in ((first, self._shape), (pixels, other.image.shape))
            ]
            if all(inside) and not self._is_ignored(np.array([x, y]), reach):
                break
        else:
            return None
        side = self._camera.width
        u, v = np.moveaxis(pixels.astype(np.float32).reshape(side, side, 2), 2, 0)
        cut = cv2.remap(other.image, u, v, cv2.INTER_CUBIC).astype(np.float64)
        slope = np.linspace(-1.0, 1.0, side)
        along, across = generator.uniform(-_GRADIENT, _GRADIENT, 2)
        light = generator.uniform(*_GAIN) * (1.0 + along * slope + across * slope[:, None])
        noisy = cut * light[..., None] + generator.normal(0.0, _NOISE, cut.shape)
        return np.clip(np.round(noisy), 0, 255).astype(np.uint8), pose


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
            each = trial.run(others or [Photograph(first, np.eye(3))], np.random.default_rng(0))
            verdicts.append(each)
            is_measured = others and len(each.errors)
            error = '{:.2f}, {:.2f}'.format(*np.quantile(1e3 * each.errors, (0.5, 0.95))) if is_measured else '-'
            print(f'{1e3 * side:7.0f}  {1e3 * each.height:9.0f}  {trial.density:7.0f}  {each.dots:12.0f}  '
                  f'{each.found:5d}  {each.wrong:5d}  {each.views:2d}  {error}')  # fmt: skip
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
            why = 'views are located at wrong places, for the pattern repeats'
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
