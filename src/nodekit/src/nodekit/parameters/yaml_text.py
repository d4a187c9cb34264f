"""Write values as YAML, and read what somebody else has written in a time that he cannot choose."""

from typing import Any

import yaml

#: How deep a text's lists and mappings may lie in each other: those of parameters take no more than
#: a few levels. Python's own reader takes seconds for thousands of open brackets.
DEEPEST = 20
#: The loader of libyaml takes a tenth of the time of the one in Python.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


#: Line breaks of Unicode, which other quotes than the double ones would not keep.
_BREAKS = frozenset("\x85\u2028\u2029")


class _Dumper(yaml.SafeDumper):
    """Writes what stands there twice, twice: nodes take no aliases."""

    def ignore_aliases(self, data: Any) -> bool:
        return True

    def represent_text(self, text: str) -> Any:
        """Return text in the quotes that keep it."""
        style = None if _BREAKS.isdisjoint(text) else '"'
        return self.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _Dumper.represent_text)


def dump(data: Any) -> str:
    """Return values as YAML; all of them come back from it as they are.

    :param data: lists, mappings, numbers, truth values and text
    :raises ValueError: if there is something else in it
    """
    try:
        text = yaml.dump(data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=1000)
    except yaml.YAMLError as error:
        raise ValueError(f"no YAML: {error}") from None
    return str(text)


def load(text: str) -> Any:
    """Return what a text of YAML says.

    :param text: the text
    :raises ValueError: if it is not valid, refers to itself, or is too deep; one line that says why
    """
    try:
        _check_structure(text)
        return yaml.load(text, _LOADER)
    except (yaml.YAMLError, RecursionError, LookupError) as error:  # the last of a value's tag
        raise ValueError(f"invalid YAML: {' '.join(str(error).split())}") from None


def _check_structure(text: str) -> None:
    """Judge a text piece by piece; what comes after the first fault is not read."""
    depth = 0
    for event in yaml.parse(text, _LOADER):
        if isinstance(
            event, yaml.AliasEvent
        ):  # with them a short text can stand for one without end
            raise ValueError("aliases (*name) are not supported")
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise ValueError(f"its lists and mappings must be at most {DEEPEST} deep")
