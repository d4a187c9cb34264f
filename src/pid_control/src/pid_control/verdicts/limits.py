"""Limits that decide whether a submission passes, from YAML."""

import math
from typing import Any, Dict, Mapping, Optional, Sequence

import yaml

#: Limits by name of the scenario and of the metric; None for unlimited.
Limits = Dict[str, Dict[str, Optional[float]]]
#: Names of the figures of each scenario.
Figures = Mapping[str, Sequence[str]]


class LimitsError(ValueError):
    """Error of invalid limits; the text names them and the allowed ones."""


class _Loader(yaml.SafeLoader):
    """YAML loader that rejects duplicate keys; YAML would silently use the last."""


def _mapping_of(loader: _Loader, node: yaml.MappingNode) -> Dict[Any, Any]:
    found: Dict[Any, Any] = {}
    for key_node, value_node in node.value:
        key = loader.construct_object(key_node, deep=True)
        if not isinstance(key, str):
            raise LimitsError(f"line {key_node.start_mark.line + 1}: {key!r} is not a name")
        if key in found:
            raise LimitsError(f"line {key_node.start_mark.line + 1}: duplicate key {key}")
        found[key] = loader.construct_object(value_node, deep=True)
    return found


_Loader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _mapping_of)


def read_limits(text: str, figures: Figures) -> Limits:
    """Parse limits.

    :param text: content of a limits file
    :param figures: names of the figures of each scenario
    :raises LimitsError: if it is not YAML, a name is unknown, or a limit is not a number
    """
    try:
        content = yaml.load(text, _Loader)  # a SafeLoader
    except LimitsError:
        raise
    except (yaml.YAMLError, RecursionError, ValueError) as error:  # ValueError: an invalid date
        raise LimitsError(f"it is not YAML: {' '.join(str(error).split())}") from None
    if content is None:
        return {}
    if not isinstance(content, dict):
        raise LimitsError(f"it must hold scenarios, each with its limits, not {content!r:.60}")
    return {
        scenario: _of_scenario(scenario, limits, figures) for scenario, limits in content.items()
    }


def merged(limits: Limits, own: Limits) -> Limits:
    """Return limits with some of them replaced.

    :param limits: all limits
    :param own: the limits that replace them
    """
    return {name: {**limits.get(name, {}), **own.get(name, {})} for name in {**limits, **own}}


def _of_scenario(scenario: str, limits: Any, figures: Figures) -> Dict[str, Optional[float]]:
    if scenario not in figures:
        raise LimitsError(f"{scenario}: unknown scenario; choose from {', '.join(figures)}")
    if not isinstance(limits, Mapping):
        raise LimitsError(f"{scenario}: must hold limits by name, not {limits!r:.60}")
    for name, limit in limits.items():
        if name not in figures[scenario]:
            allowed = ", ".join(figures[scenario])
            raise LimitsError(f"{scenario}: {name}: not measured there, but {allowed}")
        if limit is not None and not _is_limit(limit):
            raise LimitsError(
                f"{scenario}: {name}: {limit!r:.60} must be a number of at least 0, or null"
            )
    return {name: None if limit is None else float(limit) for name, limit in limits.items()}


def _is_limit(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    try:
        return math.isfinite(value) and value >= 0
    except OverflowError:
        return False
