"""Numbers in text: lossless conversion of stamps [ns] to decimal seconds and back."""

import math
from decimal import Decimal, InvalidOperation

NANOSECONDS = 1_000_000_000
# Largest time in 64-bit nanoseconds [s].
LATEST = 9_223_372_036


def stamp_from_text(text: str) -> int:
    """Return the stamp [ns] of decimal seconds, such as ``1700000000.123456789``; raise a ValueError for other text."""
    try:
        seconds = Decimal(text)
    except InvalidOperation as fault:
        raise ValueError(f'{text!r} is no time in seconds') from fault
    if not (seconds.is_finite() and abs(seconds) < LATEST):
        raise ValueError(f'{text!r} is no time in seconds')
    return round(seconds * NANOSECONDS)


def text_from_stamp(stamp_ns: int) -> str:
    """Return a stamp [ns] as seconds with nine decimals."""
    return f'{Decimal(int(stamp_ns)).scaleb(-9):.9f}'


def number_from_zero(text: str) -> float:
    """Return a finite number >= 0; raise a ValueError if it is none."""
    number = float(text)
    if not (math.isfinite(number) and number >= 0.0):
        raise ValueError(text)
    return number
