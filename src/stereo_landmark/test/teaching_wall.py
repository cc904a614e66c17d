"""Teaching sessions at the taught wall: pair 0 is the taught view, pair 1 is a later view."""

from taught_wall import HERE, METERS, RIG, TAUGHT, seen

from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.core.teaching.teaching_session import TeachingSession
from stereo_landmark.page.pair_source import StereoPairs

PAIRS = (TAUGHT, HERE)


def images_of(number):
    """Return a pair."""
    return StereoImages(*seen(PAIRS[number]))


def pairs_of_wall():
    """Return both pairs."""
    return StereoPairs(['taught', 'here'], images_of, RIG)


def new_session():
    """Return a new session."""
    return TeachingSession(images_of, RIG)


def meters_of(session):
    """Return kind and indices of the meters in the left image, from left to right."""
    shapes = (each for each in session.selectable() if each.kind is PrimitiveKind.ELLIPSE)
    found = [each for each in shapes if each.shape.semi_axes[1] > 10.0]
    assert len(found) == len(METERS)
    return [(each.kind, each.number) for each in sorted(found, key=lambda each: each.shape.centre[0])]


def session_with_meters(count=4):
    """Return a session with some meters selected."""
    session = new_session()
    for kind, number in meters_of(session)[:count]:
        session.toggle(kind, number)
    return session
