"""``shirube try lamps``: which lamps a film of the user's own camera shows, and which codes that camera can read."""

import argparse
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from shirube_cli.lamp_bands import BandedLamp, find_banded_lamps
from shirube_cli.suitability.pictures import Image, grey, parse, read_film
from vlc_beacon.core.lamp_image.row_profile import rows_from_frame
from vlc_beacon.core.light_code.code_profile import manchester_profile, rs_fsk_profile, tone_profile, ufsook_profile
from vlc_beacon.core.light_code.manchester import CHIP_TIMES
from vlc_beacon.core.light_code.rs_fsk import PREAMBLE_SYMBOL, TONE_LOWEST, TONE_SPACING, tone_log_likelihoods
from vlc_beacon.core.light_code.ufsook import FRAME_RATE
from vlc_beacon.core.receiver.light_receiver import LightReceiver
from vlc_beacon.core.settings import ReceiverSettings

_TONE, _TONE_HIGHEST = 2000.0, TONE_LOWEST + PREAMBLE_SYMBOL * TONE_SPACING  # [Hz]
_UFSOOK_HIGHEST = 240.0
_TONES = tuple(np.arange(1000.0, 11000.0, 50.0).tolist())
_EXPOSURES = {'global': (5e-4, 2e-3), 'rolling': (6e-5, 1.2e-4)}  # candidates [s]
_TABLE_EXPOSURES = (6e-5, 1.2e-4, 5e-4, 1e-3)
_ROW_TIME_STEPS = (1.0, 0.96, 1.04)  # around the line time that the fastest bands give
_CONTRAST_MIN = 0.4  # least modulation that is left by the exposure
_RATE_TOLERANCE = 0.1
_BANDS_IMAGES = 12  # in which the bands are measured
_SECONDS_MIN = 2.0  # about two packets with an ID


@dataclass(frozen=True)
class FilmLamps:
    """What a film shows: images per second, number of images, and lamps of some of them."""

    rate: float
    count: int
    lamps: tuple[BandedLamp, ...]

    @property
    def is_rolling(self) -> bool:
        """Whether half of the lamps or more have bands."""
        return bool(self.lamps) and float(np.median([lamp.cycles_per_row > 0.0 for lamp in self.lamps])) > 0.0

    @property
    def row_time(self) -> float:
        """Line time if the fastest bands are the highest tone of RS-FSK [s]; the default one without bands."""
        rates = [lamp.cycles_per_row for lamp in self.lamps if lamp.cycles_per_row > 0.0]
        return float(np.quantile(rates, 0.98)) / _TONE_HIGHEST if self.is_rolling else ReceiverSettings.row_time

    @property
    def rows(self) -> float:
        """Median diameter of a lamp [px]."""
        return float(np.median([lamp.diameter for lamp in self.lamps])) if self.lamps else 0.0


def read_ids(
    images: Sequence[Image], film: FilmLamps, row_time: float | None, exposure: float | None
) -> tuple[set[int], ReceiverSettings | None]:
    """Return the IDs that lamps send twice, and the settings that read them, the likeliest tried first."""
    shutter = 'rolling' if film.is_rolling else 'global'
    steps = _ROW_TIME_STEPS if film.is_rolling and row_time is None else (1.0,)
    lines = [min(max(step * (row_time or film.row_time), 1e-6), 1e-3) for step in steps]
    for each, line in product(_EXPOSURES[shutter] if exposure is None else (exposure,), lines):
        settings = ReceiverSettings(shutter=shutter, row_time=line, exposure_time=each)
        receiver, ids = LightReceiver((), settings), set[int]()
        for number, image in enumerate(images):
            seen = receiver.receive(number / film.rate, image)
            ids |= {lamp.unknown_id for lamp in seen if lamp.unknown_id is not None}
        if ids:
            return ids, settings
    return set(), None


def explain_failure(film: FilmLamps) -> Iterator[str]:
    """Yield why no lamp is read, each with its remedy."""
    if not film.lamps:
        yield 'no lamp is found: film bright round lamps in front of something darker'
        return
    if np.mean([lamp.is_saturated for lamp in film.lamps]) > 0.5:
        yield 'the lamps are saturated: set a shorter exposure or less gain'
    if not film.is_rolling and abs(film.rate / FRAME_RATE - 1.0) > _RATE_TOLERANCE:
        yield (
            f'no bands, and {film.rate:.0f} images/s: the lamps send nothing, or the exposure is too long (set 60 us); '
            f'a global shutter needs {FRAME_RATE:.0f} images/s'
        )
    elif film.count < _SECONDS_MIN * film.rate:
        yield f'{film.count} images are too few: film {_SECONDS_MIN:.0f} s or more, the camera at rest'
    else:
        yield 'the lamps send no packet, they are too small, or exposure and line time are others: give both'


def readable_codes(film: FilmLamps, row_time: float, exposure: float) -> Iterator[tuple[str, float, int, bool]]:
    """Yield name, contrast that the exposure leaves, rows that a lamp must cover, and whether it is readable."""
    segments = ReceiverSettings(lamp_frame_rate=min(max(film.rate, 5.0), 240.0)).segment_format
    is_fast = abs(film.rate / FRAME_RATE - 1.0) <= _RATE_TOLERANCE
    codes = (
        (ufsook_profile(), _UFSOOK_HIGHEST, not film.is_rolling and is_fast),
        (rs_fsk_profile(film.rate, row_time), _TONE_HIGHEST, film.is_rolling),
        (tone_profile(_TONE, row_time), _TONE, film.is_rolling),
        (manchester_profile(segments, row_time, exposure), 0.5 / CHIP_TIMES[0], film.is_rolling),
    )
    for profile, frequency, fits in codes:
        contrast = float(abs(np.sinc(frequency * exposure)))
        is_readable = fits and contrast >= _CONTRAST_MIN and film.rows >= profile.rows_min
        yield profile.name, contrast, profile.rows_min, is_readable


def try_lamps(arguments: Sequence[str]) -> int:
    """Print what a film shows; return 0 if a lamp is read, or else 1."""
    options = parse(_parser(), arguments, 'vlc_beacon')
    pictures, rate = read_film(options.film, options.images)
    rate = options.rate or (rate if math.isfinite(rate) else FRAME_RATE)
    images = [np.ascontiguousarray(np.rot90(each) if options.turn else each) for each in map(grey, pictures)]
    shown = images[:: -(-len(images) // _BANDS_IMAGES)]
    lamps = tuple(lamp for image in shown for lamp in find_banded_lamps(image))
    film = FilmLamps(rate, len(images), lamps)
    print(
        f'{len(images)} images, {rate:.0f} a second; {len(lamps)} lamps of {film.rows:.0f} px in {len(shown)} of them'
    )
    print('bands: a rolling shutter' if film.is_rolling else 'no bands: a global shutter, or lamps that send nothing')
    for lamp in lamps if len(images) == 1 else ():
        tone = 'no bands' if not lamp.cycles_per_row else 'a tone: --row-time gives it in Hz'
        if lamp.cycles_per_row and options.row_time:
            tone = f'{_tone(lamp, options.row_time, options.exposure):.0f} Hz'
        print(
            f'  {lamp.diameter:.0f} px at {lamp.pixel[0]}, {lamp.pixel[1]}: {tone}{", saturated" * lamp.is_saturated}'
        )
    ids, used = read_ids(images, film, options.row_time, options.exposure) if lamps else (set(), None)
    row_time = options.row_time or film.row_time
    if used is not None:
        row_time = used.row_time
        print(f'read IDs {", ".join(map(str, sorted(ids)))}; set shutter: {used.shutter}, row_time: {row_time:.3g}, '
              f'exposure_time: {used.exposure_time:.3g}')  # fmt: skip
    else:
        print(*(f'no ID is read: {reason}' for reason in explain_failure(film)), sep='\n')
    print('exposure us  code        contrast  rows needed  readable by this camera and lamp size')
    for exposure in (options.exposure,) if options.exposure else _TABLE_EXPOSURES:
        for name, contrast, rows, is_readable in readable_codes(film, row_time, exposure):
            verdict = 'yes' if is_readable else 'no'
            print(f'{1e6 * exposure:11.0f}  {name:<10}  {contrast:8.0%}  {rows:11d}  {verdict}')
    print('This camera suits: it reads these lamps.' if ids else 'This film does not show that the camera suits.')
    return int(not ids)


def _tone(lamp: BandedLamp, row_time: float, exposure: float | None) -> float:
    """Return the likeliest constant tone of a lamp [Hz]."""
    rows = rows_from_frame(0.0, 0, lamp.brightness, row_time, exposure or _TABLE_EXPOSURES[0])
    return _TONES[int(tone_log_likelihoods(rows, _TONES)[0].argmax())]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='shirube try lamps',
        description='Judge a camera for lamps that send light codes, from a film of them with the camera at rest.',
    )
    add = parser.add_argument
    add('film', type=Path, help='film, folder of images, or a photograph')
    add('--rate', type=float, help='images per second (default: that of the film, 60 for images)')
    add('--row-time', type=float, metavar='S', help='line time of the rolling shutter, if known [s]')
    add('--exposure', type=float, metavar='S', help='exposure, if known [s]')
    add('--images', type=int, default=300, help='images to read at most (default: %(default)s)')
    add('--turn', action='store_true', help='turn left first, for films whose rows are columns of the sensor')
    return parser
