"""Lamp IDs and packets from images: detection, tracking, decoding, ID confirmation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.blob_measurement import LampBlobs
from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.lamp_image.lamp_tracker import LampSample, LampTracker
from vlc_beacon.core.light_code.code_profile import CodeProfile, rs_fsk_profile, ufsook_profile
from vlc_beacon.core.light_code.rs_fsk import TONE_SEPARATION_MIN
from vlc_beacon.core.packet.command_packet import CommandPacket
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.receiver.lamp_decoder import (
    GlobalShutterDecoder,
    LampDecoder,
    LampView,
    RollingShutterDecoder,
    RowTiming,
    row_timing,
)
from vlc_beacon.core.receiver.tracked_lamp import SkipReason, TrackedLamp
from vlc_beacon.core.settings import LampSettings, ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


@dataclass(frozen=True)
class LampObservation:
    """A lamp in the image with its ID and messages.

    Attributes:
        sample: tracked position and brightness.
        beacon: confirmed ID, None while unconfirmed.
        unknown_id: confirmed ID that is not in the beacons file, None for none.
        commands: command packets completed by this image.
        skip_reason: reason why the lamp is not decoded, None if it is decoded.
        message: text or bytes completed by this image, not authenticated, None for none.
    """

    sample: LampSample
    beacon: int | None
    unknown_id: int | None
    commands: tuple[CommandPacket, ...]
    skip_reason: SkipReason | None = None
    message: str | bytes | None = None


class LightReceiver:
    """Tracks and decodes all lamps in view."""

    def __init__(self, beacons: Iterable[Beacon], settings: ReceiverSettings) -> None:
        """Start without lamps.

        Args:
            beacons: lamps of the beacons file.
            settings: receiver settings with camera and lamps.

        Raises:
            VlcBeaconError: only some beacons have a frequency, only one beacon is given, or two frequencies are too
                close.
        """
        known = list(beacons)
        self._known = frozenset(beacon.id for beacon in known)
        self._beacon_tones = _beacon_tones(known) if settings.is_rolling else {}
        self._timing = row_timing(settings, self._beacon_tones.values())
        self._settings = settings
        profile = _code_profile(settings)
        self._readable_diameter = float(profile.rows_min)
        # Reception that starts within the longest packet has it complete after twice its duration.
        self._acquisition_timeout = 2.0 * profile.seconds_per_100_bytes
        self._detector = LampDetector(_lamp_settings(settings, self._timing))
        self._tracks = LampTracker(split_lamps=not settings.is_rolling)
        self._lamps: dict[int, TrackedLamp] = {}
        self._backgrounds: dict[int, float] = {}

    def receive(self, stamp: float, image: NDArray[np.uint8], turn: float = 0.0) -> list[LampObservation]:
        """Process an image and return the tracked lamps.

        Args:
            stamp: stamp of the image, later than the last one [s].
            image: grey image, shape (h, w).
            turn: image rotation since the last image, from u to v, if known from odometry [rad].

        Raises:
            LampImageError: the image has a wrong type or is too small.
        """
        blobs = self._detector.detect(image)
        samples = self._tracks.update(stamp, image, blobs, turn)
        self._update_lamps(samples, blobs)
        return [self._observe(stamp, image, sample) for sample in samples]

    def _update_lamps(self, samples: list[LampSample], blobs: LampBlobs) -> None:
        """Add new lamps and drop those whose tracks ended."""
        lamps = {sample.key: self._lamps.get(sample.key) or self._new_lamp() for sample in samples}
        lit = {sample.key: float(blobs.backgrounds[sample.blob]) for sample in samples if sample.is_lit}
        self._backgrounds = {key: lit.get(key, self._backgrounds.get(key, 0.0)) for key in lamps}
        self._lamps = lamps

    def _observe(self, stamp: float, image: NDArray[np.uint8], sample: LampSample) -> LampObservation:
        lamp = self._lamps[sample.key]
        lamp.update(LampView(stamp, image, sample, self._backgrounds[sample.key]))
        return LampObservation(
            sample, lamp.beacon, lamp.unknown_id, tuple(lamp.commands), lamp.skip_reason, lamp.message
        )

    def _new_lamp(self) -> TrackedLamp:
        return TrackedLamp(
            self._new_decoder(), self._known, self._readable_diameter, self._acquisition_timeout
        )

    def _new_decoder(self) -> LampDecoder:
        if self._settings.is_rolling:
            return RollingShutterDecoder(self._timing, self._beacon_tones)
        return GlobalShutterDecoder(self._settings.exposure_time)


def _beacon_tones(beacons: list[Beacon]) -> dict[int, float]:
    tones = {beacon.id: beacon.frequency for beacon in beacons if beacon.frequency is not None}
    if tones and (len(tones) < len(beacons) or len(tones) == 1):
        raise VlcBeaconError(
            f'beacons: {len(tones)} of {len(beacons)} have a frequency; '
            'give one to all beacons (two or more), or to none if the lamps send their IDs'
        )
    ordered = sorted(tones, key=lambda id_: tones[id_])
    for one, other in pairwise(ordered):
        if tones[other] - tones[one] < TONE_SEPARATION_MIN:
            raise VlcBeaconError(
                f'beacons: {one} and {other} have the frequencies {tones[one]:g} Hz and {tones[other]:g} Hz; '
                f'set them {TONE_SEPARATION_MIN:g} Hz apart or more'
            )
    return tones


def _code_profile(settings: ReceiverSettings) -> CodeProfile:
    """Return the profile of the light code for the smallest lamps."""
    if settings.is_rolling:
        return rs_fsk_profile(settings.lamp_frame_rate, settings.row_time)
    return ufsook_profile()


def _lamp_settings(settings: ReceiverSettings, timing: RowTiming) -> LampSettings:
    return replace(settings.lamps, stripe_rows=timing.stripe_rows if settings.is_rolling else 0.0)
