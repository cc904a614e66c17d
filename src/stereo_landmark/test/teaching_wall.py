"""An engineer in front of the taught wall: pair 0 is the taught one, pair 1 is what the robot sees later."""

from taught_wall import HERE, METERS, RIG, TAUGHT, seen

from stereo_landmark.core.pair.stereo_images import StereoImages
from stereo_landmark.core.procedure.primitive import Kind
from stereo_landmark.core.teaching.teaching_session import TeachingSession

PAIRS = (TAUGHT, HERE)


def images_of(number):
    """Return a pair."""
    return StereoImages(*seen(PAIRS[number]))


def new_session():
    """Return a session in which nothing was done."""
    return TeachingSession(images_of, RIG)


def meters_of(session):
    """Return the kind and the numbers of the meters in the left image, from left to right."""
    found = [each for each in session.found() if each.kind is Kind.ELLIPSE and each.shape.semi_axes[1] > 10.0]
    assert len(found) == len(METERS)
    return [(each.kind, each.number) for each in sorted(found, key=lambda each: each.shape.centre[0])]


def session_with_meters(count=4):
    """Return a session in which some meters were chosen."""
    session = new_session()
    for kind, number in meters_of(session)[:count]:
        session.toggle(kind, number)
    return session
