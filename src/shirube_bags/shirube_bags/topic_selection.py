"""Selection of a topic of a bag."""

from __future__ import annotations

from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import BagError


def select_topic(
    bag: BagReader,
    name: str | None,
    types: tuple[str, ...],
    defaults: tuple[str, ...],
    *,
    is_optional: bool = False,
) -> str:
    """Return the named topic, else a default one, else the only one of the type; empty if there is none.

    Args:
        bag: open bag.
        name: name given by the user, None if not given.
        types: accepted message types; the first one appears in error messages.
        defaults: default names, in order of preference.
        is_optional: whether the topic may be missing.

    Raises:
        BagError: the named topic is missing or has another type, or the choice is not unique.
    """
    matching = sorted(topic.name for topic in bag.topics.values() if topic.msgtype in types)
    kind = types[0].rpartition('/')[2]
    if name is not None:
        (name,) = bag.select_topics([name])
        if name not in matching:
            raise BagError(f'{bag.path}: topic {name} is {bag.topics[name].msgtype}, no {kind}')
        return name
    candidates = [topic for topic in defaults if topic in matching] or matching
    if candidates and (len(matching) == 1 or candidates[0] in defaults):
        return candidates[0]
    if is_optional:
        return ''
    if not matching:
        raise BagError(f'{bag.path}: has no topic of type {kind}; it has {", ".join(sorted(bag.topics))}')
    raise BagError(f'{bag.path}: has several topics of type {kind}; name one of {", ".join(matching)}')
