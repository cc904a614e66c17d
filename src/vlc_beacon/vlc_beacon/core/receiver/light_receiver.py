"""Lamp IDs and packets from images: detection, tracking, decoding, ID confirmation."""

import math
from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.lamp_image.lamp_tracker import LampTracker
from vlc_beacon.core.light_code.code_profile import rs_fsk_profile, ufsook_profile
from vlc_beacon.core.light_code.rs_fsk import TONE_SEPARATION_MIN
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.receiver.lamp_decoder import (
    GlobalShutterDecoder,
    LampDecoder,
    LampView,
    RollingShutterDecoder,
    band_rows,
)
from vlc_beacon.core.receiver.tracked_lamp import LampObservation, TrackedLamp
from vlc_beacon.core.settings import ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


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
        known, is_rolling = list(beacons), settings.is_rolling
        self._known = frozenset(beacon.id for beacon in known)
        self._beacon_tones = _beacon_tones(known) if is_rolling else {}
        self._profile = rs_fsk_profile(settings.lamp_frame_rate, settings.row_time) if is_rolling else ufsook_profile()
        self.apply_settings(settings)
        self._tracker = LampTracker(split_lamps=not is_rolling)
        self._lamps: dict[int, TrackedLamp] = {}

    def apply_settings(self, settings: ReceiverSettings) -> None:
        """Detect lamps by other settings; tracked lamps are kept."""
        self._settings = settings
        rows = band_rows(settings, self._beacon_tones.values()) if settings.is_rolling else 0.0
        self._detector = LampDetector(replace(settings.lamps, stripe_rows=rows))

    def receive(self, stamp: float, image: NDArray[np.uint8], image_rotation: float = 0.0) -> list[LampObservation]:
        """Process an image and return the tracked lamps.

        Args:
            stamp: stamp of the image, later than the last one [s].
            image: grey image, shape (h, w).
            image_rotation: image rotation since the last image, from u to v, if known from odometry [rad].

        Raises:
            LampImageError: the image has a wrong type or is too small.
        """
        # Section 3.1: detect bright round blobs (the paper trains YOLOv5 instead).
        blobs = self._detector.detect(image)
        # Follow each lamp from frame to frame, also while it is dark, and sample the brightness of its halves.
        samples = self._tracker.update(stamp, image, blobs, image_rotation)
        # One decoder for each track, until the track ends.
        self._lamps = {sample.key: self._lamps.get(sample.key) or self._new_lamp() for sample in samples}
        # Section 2.1: demodulate ID, data and commands from the brightness of halves or rows.
        observations = []
        for sample in samples:
            background = float(blobs.backgrounds[sample.blob]) if sample.is_lit else math.nan
            view = LampView(stamp, image, sample, background)
            observations.append(self._lamps[sample.key].update(view))
        return observations

    def _new_lamp(self) -> TrackedLamp:
        decoder: LampDecoder = GlobalShutterDecoder(self._settings.exposure_time)
        if self._settings.is_rolling:
            decoder = RollingShutterDecoder(self._settings, self._beacon_tones)
        # Reception that starts within the longest packet has it complete after twice its duration.
        timeout = 2.0 * self._profile.seconds_per_100_bytes
        return TrackedLamp(decoder, self._known, float(self._profile.rows_min), timeout)


def _beacon_tones(beacons: list[Beacon]) -> dict[int, float]:
    tones = {beacon.id: beacon.frequency for beacon in beacons if beacon.frequency is not None}
    if tones and (len(tones) < len(beacons) or len(tones) == 1):
        raise VlcBeaconError(
            f'beacons: {len(tones)} of {len(beacons)} have a frequency; '
            'give one to all beacons (two or more), or to none if the lamps send their IDs'
        )
    for one, other in pairwise(sorted(tones, key=lambda id_: tones[id_])):
        if tones[other] - tones[one] < TONE_SEPARATION_MIN:
            raise VlcBeaconError(
                f'beacons: {one} and {other} have the frequencies {tones[one]:g} Hz and {tones[other]:g} Hz; '
                f'set them {TONE_SEPARATION_MIN:g} Hz apart or more'
            )
    return tones
