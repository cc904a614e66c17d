"""What became of a pose."""

from __future__ import annotations

from enum import Enum


class Verdict(Enum):
    """The judgement of one pose; the text is for people."""

    USED = 'used'
    RESET = 'the pose was set to it'
    WAITS = 'waits for a second opinion at the start'
    GATED = 'too far from the pose'
    PROBATION = 'near again, on probation'
    MOVES_OTHERWISE = 'moves otherwise than odometry'


class Refusal(Enum):
    """Why a pose does not even get a judgement; the text is for people."""

    NOT_FINITE = 'not finite'
    FAR = 'farther away than any robot'
    BAD_COVARIANCE = 'covariance is none of a pose'
    NO_STAMP = 'stamp is 0'
    FUTURE = 'stamp is in the future'
    TOO_OLD = 'stamp is too old'
    DUPLICATE = 'stamp came before'
