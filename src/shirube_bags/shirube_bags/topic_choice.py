"""Which topic of a bag is meant."""

from __future__ import annotations

from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import BagError


def choose_topic(
    bag: BagReader,
    name: str | None,
    types: tuple[str, ...],
    usual: tuple[str, ...],
    *,
    is_optional: bool = False,
) -> str:
    """Return the topic that is named, else a usual one, else the only one of the type; an empty name is none.

    Args:
        bag: an open bag.
        name: that the user gave, None for none.
        types: message types that will do, the first one names the kind to people.
        usual: names to take without asking, the first ones first.
        is_optional: whether there may be none.

    Raises:
        BagError: the named topic is missing or of another type, or none or several are there to choose from.
    """
    fitting = sorted(topic.name for topic in bag.topics.values() if topic.msgtype in types)
    kind = types[0].rpartition('/')[2]
    if name is not None:
        (name,) = bag.select_topics([name])
        if name not in fitting:
            raise BagError(f'{bag.path}: topic {name} is {bag.topics[name].msgtype}, no {kind}')
        return name
    candidates = [topic for topic in usual if topic in fitting] or fitting
    if candidates and (len(fitting) == 1 or candidates[0] in usual):
        return candidates[0]
    if is_optional:
        return ''
    if not fitting:
        raise BagError(f'{bag.path}: has no topic of type {kind}; it has {", ".join(sorted(bag.topics))}')
    raise BagError(f'{bag.path}: has several topics of type {kind}; name one of {", ".join(fitting)}')
