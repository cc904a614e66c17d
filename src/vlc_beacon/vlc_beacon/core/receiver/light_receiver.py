"""Lamp IDs and packets from images: detection, tracking, decoding, ID confirmation."""

import json
import math
from collections import deque
from collections.abc import Iterable
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.lamp_image.lamp_tracker import LampSample, LampTracker
from vlc_beacon.core.light_code.code_profile import rs_fsk_profile, ufsook_profile
from vlc_beacon.core.light_code.rs_fsk import TONE_SEPARATION_MIN
from vlc_beacon.core.packet.command_packet import CommandPacket, ShortCommandPacket
from vlc_beacon.core.packet.data_packet import DataPacket, IdPacket, MessageAssembler
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.receiver.lamp_decoder import (
    GlobalShutterDecoder,
    LampDecoder,
    LampView,
    RollingShutterDecoder,
    band_rows,
)
from vlc_beacon.core.settings import ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

BACKOFF_TIME = 60.0
"""Pause between acquisition attempts [s]."""
UNADDRESSED_MAX = 4
"""Number of short commands that wait for the ID of their lamp."""


class SkipReason(Enum):
    """Reason why a lamp is not decoded."""

    NO_CODE = 'without a code'
    TOO_SMALL = 'too small to be decoded'


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


@dataclass(frozen=True)
class LampMessage:
    """Text or bytes that a lamp has sent, not authenticated; the sender is None while its ID is unconfirmed."""

    sender: int | None
    content: str | bytes

    @property
    def sender_name(self) -> str:
        """The lamp as named in logs and diagnostics."""
        return 'a lamp' if self.sender is None else f'lamp {self.sender}'

    @property
    def printable(self) -> str:
        """The content in one line: text quoted, bytes in hexadecimal."""
        return self.content.hex() if isinstance(self.content, bytes) else repr(self.content)

    def to_json(self) -> str:
        """Return beacon and text, or beacon and bytes in hexadecimal, as JSON."""
        content = self.content
        field = {'text': content} if isinstance(content, str) else {'bytes': content.hex()}
        return json.dumps({'beacon': self.sender, **field}, ensure_ascii=False)


class AcquisitionBackoff:
    """Alternates between acquisition and pause without packets: mains lamps, for example, flicker permanently.

    Args:
        seconds: duration of an acquisition attempt [s].

    Attributes:
        has_timed_out: whether an acquisition attempt has timed out since the last packet.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._since: float | None = None
        self.has_timed_out = False

    def is_active(self, stamp: float) -> bool:
        """Return whether to decode the lamp at a time [s]."""
        if self._since is None or stamp < self._since or stamp >= self._since + self._seconds + BACKOFF_TIME:
            self._since = stamp
        self.has_timed_out |= stamp >= self._since + self._seconds
        return stamp < self._since + self._seconds

    def reset(self, stamp: float) -> None:
        """Restart the timeout after a received packet [s]."""
        self._since, self.has_timed_out = stamp, False


class TrackedLamp:
    """A lamp from frame to frame."""

    def __init__(
        self, decoder: LampDecoder, known: AbstractSet[int], readable_diameter: float, acquisition_timeout: float
    ) -> None:
        """Start with a new lamp.

        Args:
            decoder: decoder of this lamp.
            known: IDs in the beacons file.
            readable_diameter: minimum diameter for decoding [px].
            acquisition_timeout: acquisition timeout of a lamp without an ID [s].
        """
        self._decoder = decoder
        self._known = known
        self._readable_diameter = readable_diameter
        self._backoff = AcquisitionBackoff(acquisition_timeout)
        self._assembler = MessageAssembler()
        self._last_id: int | None = None
        self._beacon: int | None = None
        self._unknown_id: int | None = None
        self._unaddressed: deque[ShortCommandPacket] = deque(maxlen=UNADDRESSED_MAX)

    def update(self, view: LampView) -> LampObservation:
        """Process a frame."""
        commands: list[CommandPacket] = []
        message: str | bytes | None = None
        if self._backoff.is_active(view.stamp) or self._beacon is not None:
            for received in self._decoder.read(view):
                self._backoff.reset(view.stamp)
                match received.packet:
                    case CommandPacket() as command:
                        commands.append(command)
                    case ShortCommandPacket() as short:
                        self._unaddressed.append(short)
                    case DataPacket() as fragment:
                        completed = self._assembler.add(fragment)
                        message = message if completed is None else completed
                    case IdPacket(beacon):
                        self._confirm(beacon)
        if self._beacon is not None:
            # A short packet names no beacon: it waits until the ID of the lamp is confirmed.
            commands += [short.addressed_to(self._beacon) for short in self._unaddressed]
            self._unaddressed.clear()
        skip_reason = None
        if self._backoff.has_timed_out and self._beacon is None:
            is_small = 2.0 * view.sample.radius < self._readable_diameter
            skip_reason = SkipReason.TOO_SMALL if is_small else SkipReason.NO_CODE
        return LampObservation(view.sample, self._beacon, self._unknown_id, tuple(commands), skip_reason, message)

    def _confirm(self, beacon: int) -> None:
        """Confirm an ID after two equal consecutive ID packets."""
        if beacon == self._last_id:
            self._beacon, self._unknown_id = (beacon, None) if beacon in self._known else (None, beacon)
        self._last_id = beacon


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
