"""Reference implementation of BLAKE2s from RFC 7693 for tests."""

from __future__ import annotations

import struct

IV = (0x6A09E667, 0xBB67AE85, 0x3C6EF372, 0xA54FF53A, 0x510E527F, 0x9B05688C, 0x1F83D9AB, 0x5BE0CD19)
SIGMA = (
    (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
    (14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3),
    (11, 8, 12, 0, 5, 2, 15, 13, 10, 14, 3, 6, 7, 1, 9, 4),
    (7, 9, 3, 1, 13, 12, 11, 14, 2, 6, 5, 10, 4, 0, 15, 8),
    (9, 0, 5, 7, 2, 4, 10, 15, 14, 1, 11, 12, 6, 8, 3, 13),
    (2, 12, 6, 10, 0, 11, 8, 3, 4, 13, 7, 5, 15, 14, 1, 9),
    (12, 5, 1, 15, 14, 13, 4, 10, 0, 7, 6, 3, 9, 2, 8, 11),
    (13, 11, 7, 14, 12, 1, 3, 9, 5, 0, 15, 4, 8, 6, 2, 10),
    (6, 15, 14, 9, 11, 3, 0, 8, 12, 2, 13, 7, 1, 4, 10, 5),
    (10, 2, 8, 4, 7, 6, 1, 5, 15, 11, 9, 14, 3, 12, 13, 0),
)
LANES = (
    *((0, 4, 8, 12), (1, 5, 9, 13), (2, 6, 10, 14), (3, 7, 11, 15)),
    *((0, 5, 10, 15), (1, 6, 11, 12), (2, 7, 8, 13), (3, 4, 9, 14)),
)
MASK = 0xFFFFFFFF


def blake2s(data: bytes, key: bytes, digest_size: int) -> bytes:
    """Return the keyed hash."""
    message = (key.ljust(64, b'\0') if key else b'') + data
    blocks = [message[i : i + 64] for i in range(0, len(message), 64)] or [b'']
    state = list(IV)
    state[0] ^= 0x01010000 ^ len(key) << 8 ^ digest_size
    for i, block in enumerate(blocks):
        is_last = i == len(blocks) - 1
        state = compressed(state, block.ljust(64, b'\0'), len(message) if is_last else 64 * (i + 1), is_last)
    return struct.pack('<8I', *state)[:digest_size]


def compressed(state: list[int], block: bytes, counted: int, is_last: bool) -> list[int]:
    words = struct.unpack('<16I', block)
    v = [*state, *IV]
    v[12] ^= counted & MASK
    v[13] ^= counted >> 32
    v[14] ^= MASK if is_last else 0
    for order in SIGMA:
        for lane, (a, b, c, d) in enumerate(LANES):
            for word, turn_d, turn_b in (
                (words[order[2 * lane]], 16, 12),
                (words[order[2 * lane + 1]], 8, 7),
            ):
                v[a] = (v[a] + v[b] + word) & MASK
                v[d] = turned(v[d] ^ v[a], turn_d)
                v[c] = (v[c] + v[d]) & MASK
                v[b] = turned(v[b] ^ v[c], turn_b)
    return [state[i] ^ v[i] ^ v[i + 8] for i in range(8)]


def turned(word: int, bits: int) -> int:
    return (word >> bits | word << (32 - bits)) & MASK
