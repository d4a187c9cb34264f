"""Selection of the topics, services and actions to bridge; imports neither ROS."""

import fnmatch
import functools
import re
from typing import Iterable, List, NamedTuple, Sequence, Set, Tuple

from ros2_bridge.rules.rates import MaxRates
from ros2_bridge.rules.renaming import Renaming

#: Log topic, bridged in one direction, with the names of the nodes.
ROSOUT = "/rosout"
#: Names that each side uses for itself, or that are bridged specially.
RESERVED_NAMES = (
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
#: Packages whose types each ROS uses for itself, or that are bridged specially: the name of
#: dynamic_reconfigure's service ``set_parameters`` also exists in ROS 2.
RESERVED_PACKAGES = (
    "dynamic_reconfigure/",
    "roscpp/",
    "rcl_interfaces/",
    "type_description_interfaces/",
)


class Rules(NamedTuple):
    """The user's rules for what is bridged.

    :param to_ros2, to_ros1: enabled directions
    :param allow, deny: patterns of ROS 1 names, such as ``/robot/*``; deny takes precedence
    :param names: renaming rules
    :param max_rates: maximum rates of topics
    """

    to_ros2: bool
    to_ros1: bool
    allow: Sequence[str]
    deny: Sequence[str]
    names: Renaming = Renaming()
    max_rates: MaxRates = MaxRates()

    def enables(self, route: "Route") -> bool:
        """Return whether the direction of this pair is enabled."""
        return (self.to_ros2 if route.to_ros2 else self.to_ros1) and self.allows(route.name)

    def allows(self, name: str) -> bool:
        """Return whether a topic or service with this ROS 1 name may be bridged."""
        denied, allowed = _compiled(tuple(self.deny)), _compiled(tuple(self.allow))
        if is_reserved(name) or denied.match(name) or not allowed.match(name):
            return False
        other = self.names.in_ros2(name)
        return other is not None and not is_reserved(other)


def is_reserved(name: str) -> bool:
    """Return whether a name is reserved: used by each ROS for itself, or bridged specially."""
    return _compiled(RESERVED_NAMES).match(name) is not None


@functools.lru_cache(maxsize=16)
def _compiled(patterns: Tuple[str, ...]) -> "re.Pattern[str]":
    """Return a single expression for all patterns; without patterns, one that matches nothing."""
    return re.compile("|".join(map(fnmatch.translate, patterns)) or r"(?!)")


class Route(NamedTuple):
    """Topic, service or action to bridge, with its direction.

    :param name: its name in ROS 1
    :param to_ros2: whether from ROS 1 to ROS 2
    """

    name: str
    to_ros2: bool


def select_routes(rules: Rules, in_ros1: Set[str], in_ros2: Set[str]) -> List[Route]:
    """Return the pairs to bridge, sorted by name.

    :param rules: the user's rules
    :param in_ros1: topics or services that others offer in ROS 1
    :param in_ros2: the same in ROS 2, by ROS 1 name
    """
    routes = [*(Route(name, True) for name in in_ros1), *(Route(name, False) for name in in_ros2)]
    return sorted(filter(rules.enables, routes))


def rank_names(there: Iterable[str], *kinds: Set[str]) -> List[str]:
    """Return names by priority, for use with a limit.

    :param there: names already in use, which keep their place while wanted
    :param kinds: wanted names, in groups of decreasing priority
    """
    order = [name for name in there if any(name in kind for kind in kinds)]
    for kind in kinds:
        order += sorted(kind.difference(order))
    return order


def parameter_services(services: Set[str]) -> Set[str]:
    """Return the services through which nodekit nodes describe and change their parameters.

    ROS 2 has its own services for that.

    :param services: of ROS 1
    """
    spaces = {name.rpartition("/")[0] for name in services if name.endswith("/describe")}
    both = {space for space in spaces if f"{space}/change" in services}
    return {f"{space}/{name}" for space in both for name in ("describe", "change")}
