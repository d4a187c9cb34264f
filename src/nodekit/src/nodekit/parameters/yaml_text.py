"""YAML writer, and a reader whose time is bounded for untrusted text."""

from typing import Any

import yaml

#: Deepest nesting of lists and mappings; parameters need a few levels. Python's reader takes
#: seconds for thousands of open brackets.
DEEPEST = 20
#: libyaml's loader takes a tenth of the time of Python's.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


#: Unicode line breaks, which only double quotes keep.
_BREAKS = frozenset("\x85\u2028\u2029")


class _Dumper(yaml.SafeDumper):
    """Dumper without aliases, which nodes do not accept."""

    def ignore_aliases(self, data: Any) -> bool:
        return True

    def represent_text(self, text: str) -> Any:
        """Return text in quotes that keep its line breaks."""
        style = None if _BREAKS.isdisjoint(text) else '"'
        return self.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _Dumper.represent_text)


def dump(data: Any) -> str:
    """Return values as YAML, without loss.

    :param data: lists, mappings, numbers, booleans and text
    :raises ValueError: if a value has another type
    """
    try:
        text = yaml.dump(data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=1000)
    except yaml.YAMLError as error:
        raise ValueError(f"no YAML: {error}") from None
    return str(text)


def load(text: str) -> Any:
    """Parse YAML text.

    :param text: the text
    :raises ValueError: if the text is invalid, has aliases, or is nested too deep; in one line
    """
    try:
        _check_structure(text)
        return yaml.load(text, _LOADER)
    except (yaml.YAMLError, RecursionError, LookupError) as error:  # LookupError: a value's tag
        raise ValueError(f"invalid YAML: {' '.join(str(error).split())}") from None


def _check_structure(text: str) -> None:
    """Check a text event by event, and stop at the first error."""
    depth = 0
    for event in yaml.parse(text, _LOADER):
        if isinstance(event, yaml.AliasEvent):  # a short text could expand without limit
            raise ValueError("aliases (*name) are not supported")
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise ValueError(f"its lists and mappings must be at most {DEEPEST} deep")
