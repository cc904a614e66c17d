"""Unknown and misspelled names in parameter files."""

from collections.abc import Iterator, Mapping
from difflib import get_close_matches

from shirube_cli.migrate import PARAMETERS
from shirube_cli.settings_of_nodes import OTHER_SETTINGS, SETTINGS_OF_NODES
from shirube_core.settings import describe_settings

_ALWAYS = {'use_sim_time', 'start_type_description_service'}


def unknown_names(content: object, path: tuple[str, ...] = ()) -> Iterator[tuple[str, str]]:
    """Yield each parameter in the content of a parameter file that no node it is for has, and the closest name."""
    for key, value in content.items() if isinstance(content, Mapping) else ():
        if key != PARAMETERS:
            yield from unknown_names(value, (*path, str(key)))
            continue
        node, given = '/'.join(path), dict(_flatten(value))
        known = known_names(node, given)
        for name in given if known else ():
            if name not in known and not name.startswith('qos_overrides.'):
                yield name, next(iter(get_close_matches(name, known, n=1)), '')


def known_names(node: str, given: Mapping[str, object]) -> set[str]:
    """Return the parameters of a node, of all nodes for a wildcard, none for a foreign node."""
    names: set[str] = set()
    for own, sections in SETTINGS_OF_NODES.items():
        if own == node.rpartition('/')[2] or '*' in node.rpartition('/')[2]:
            names |= {each.name for cls in sections.values() for each in describe_settings(cls)} | _ALWAYS
            prefixed = [cls for title, cls in OTHER_SETTINGS.items() if title.startswith(f'{own}: each source')]
            names |= {'sources'} if prefixed else set()
            sources = given.get('sources', ())
            for source in sources if isinstance(sources, (list, tuple)) else ():
                names |= {f'{source}.{each.name}' for cls in prefixed for each in describe_settings(cls)}
    return names


def _flatten(content: object, prefix: str = '') -> Iterator[tuple[str, object]]:
    for key, value in content.items() if isinstance(content, Mapping) else ():
        if isinstance(value, Mapping):
            yield from _flatten(value, f'{prefix}{key}.')
        else:
            yield f'{prefix}{key}', value
