"""Integer arithmetic of C: 16 and 32 bits, division truncated towards zero."""

from __future__ import annotations


def wrap_signed(value: int, bits: int) -> int:
    """Wrap an integer to a signed one of ``bits`` bits."""
    half = 1 << (bits - 1)
    return (value + half) % (2 * half) - half


def divide_truncating(numerator: int, denominator: int) -> int:
    """Return the quotient truncated towards zero; 0 for a division by zero, which raises no error on AVR."""
    if denominator == 0:
        return 0
    quotient = abs(numerator) // abs(denominator)
    return quotient if (numerator < 0) == (denominator < 0) else -quotient


def atoi(text: str) -> int:
    """Return the 16-bit integer at the start of a text, 0 if there is none: ``nan`` is 0, ``1e3`` is 1."""
    stripped = text.lstrip(' \t\n\v\f\r')
    sign = -1 if stripped.startswith('-') else 1
    value = 0
    for character in stripped[1:] if stripped[:1] in ('-', '+') else stripped:
        if character not in '0123456789':
            break
        value = 10 * value + int(character)
    return wrap_signed(sign * value, 16)
