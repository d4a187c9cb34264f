"""Selection of topics and services, and their directions; imports neither ROS."""

import fnmatch
import functools
import re
from typing import Iterable, List, NamedTuple, Sequence, Set, Tuple

from ros2_bridge.rules.rates import MaxRates
from ros2_bridge.rules.renaming import Renaming

#: The log, which is bridged one way, with the names of the nodes.
ROSOUT = "/rosout"
#: Names that each side has for itself, or that are bridged in a way of their own.
NEVER = (
    ROSOUT,
    "/rosout_agg",
    "/parameter_events",
    "/statistics",
    "*/_action/*",
    "*/_service_event",
    "*/get_loggers",
    "*/set_logger_level",
    "*/get_type_description",
)
#: Packages whose types each ROS has for itself, or that are bridged in a way of their own:
#: dynamic_reconfigure's service ``set_parameters`` has the very name of ROS 2's.
OWN_WAYS = ("dynamic_reconfigure/", "roscpp/", "rcl_interfaces/", "type_description_interfaces/")


class Rules(NamedTuple):
    """Rules of the user for what is bridged.

    :param to_ros2, to_ros1: the ways that are open
    :param allow, deny: patterns of names in ROS 1, such as ``/robot/*``; what is denied is not
        allowed
    :param names: what has another name in ROS 2
    :param max_rates: how often topics are passed on at most
    """

    to_ros2: bool
    to_ros1: bool
    allow: Sequence[str]
    deny: Sequence[str]
    names: Renaming = Renaming()
    max_rates: MaxRates = MaxRates()

    def opens(self, way: "Way") -> bool:
        """Tell whether something may be bridged in this way."""
        return (self.to_ros2 if way.to_ros2 else self.to_ros1) and self.allows(way.name)

    def allows(self, name: str) -> bool:
        """Tell whether a topic or service that has this name in ROS 1 may be bridged."""
        denied, allowed = _compiled(tuple(self.deny)), _compiled(tuple(self.allow))
        if is_never_bridged(name) or denied.match(name) or not allowed.match(name):
            return False
        other = self.names.in_ros2(name)
        return other is not None and not is_never_bridged(other)


def is_never_bridged(name: str) -> bool:
    """Tell whether each side has topics and services of this name for itself."""
    return _compiled(NEVER).match(name) is not None


@functools.lru_cache(maxsize=16)
def _compiled(patterns: Tuple[str, ...]) -> "re.Pattern[str]":
    """Return one expression for all of some patterns; for none, one that matches nothing."""
    return re.compile("|".join(map(fnmatch.translate, patterns)) or r"(?!)")


class Way(NamedTuple):
    """Something to be bridged one way.

    :param name: of the topic or service in ROS 1
    :param to_ros2: whether from ROS 1 to ROS 2
    """

    name: str
    to_ros2: bool


def wanted(rules: Rules, in_ros1: Set[str], in_ros2: Set[str]) -> List[Way]:
    """Return what is to be bridged, in order of names.

    :param rules: what the user allows
    :param in_ros1: topics that others publish in ROS 1, or services that they offer
    :param in_ros2: the same of ROS 2, by their names in ROS 1
    """
    ways = [*(Way(name, True) for name in in_ros1), *(Way(name, False) for name in in_ros2)]
    return sorted(filter(rules.opens, ways))


def rank_names(there: Iterable[str], *kinds: Set[str]) -> List[str]:
    """Return names, the first of which appear where not all may.

    :param there: those that appear already, and stay as long as they are wanted
    :param kinds: those that are wanted, of each kind after the kinds before it
    """
    order = [name for name in there if any(name in kind for kind in kinds)]
    for kind in kinds:
        order += sorted(kind.difference(order))
    return order


def parameter_services(services: Set[str]) -> Set[str]:
    """Return those by which nodes made with nodekit describe and change their parameters.

    ROS 2 has its own for that.

    :param services: of ROS 1
    """
    spaces = {name.rpartition("/")[0] for name in services if name.endswith("/describe")}
    both = {space for space in spaces if f"{space}/change" in services}
    return {f"{space}/{name}" for space in both for name in ("describe", "change")}
