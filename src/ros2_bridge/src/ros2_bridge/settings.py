"""What the user can choose: parameters, and qualities of service."""

import fnmatch
from typing import Any, Dict, List, Mapping, NamedTuple

from nodekit import (
    BoolParameter,
    EnumParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    ParameterError,
    ParameterSet,
    StringParameter,
)
from ros2_bridge.pairing import Rules


class BridgeParameters(ParameterSet):
    """The parameters of the bridge."""

    direction = EnumParameter(
        "both", choices=("both", "to_ros2", "to_ros1"), help="which way topics and services go"
    )
    allow = ListParameter(
        ("*",),
        element=StringParameter("", help="a pattern"),
        help="patterns of topics and services that are bridged",
    )
    deny = ListParameter(
        (),
        element=StringParameter("", help="a pattern"),
        help="patterns of topics and services that are not",
    )
    parameters = BoolParameter(True, help="whether parameters are bridged")
    depth = IntParameter(
        1000, minimum=1, maximum=100_000, help="how many messages of a topic ROS 2 keeps in a burst"
    )
    max_nodes = IntParameter(
        100, minimum=0, maximum=1000, help="most nodes of ROS 1 that appear in ROS 2"
    )
    service_timeout = FloatParameter(
        5.0, unit="s", above=0.0, maximum=3600.0, help="longest wait for the answer of a service"
    )

    def openings(self) -> Rules:
        """Return what may be bridged."""
        to_ros2, to_ros1 = self.direction != "to_ros1", self.direction != "to_ros2"
        return Rules(to_ros2, to_ros1, self.allow, self.deny)


class Quality(NamedTuple):
    """The quality of service of a topic in ROS 2.

    :param depth: how many messages are kept
    :param latched: whether they are kept for those who come later too
    :param best_effort: whether messages may be lost
    """

    depth: int
    latched: bool = False
    best_effort: bool = False


class Qualities:
    """The quality of service of each topic: the user's, or one that fits what others publish.

    :param depth: how many messages are kept where the user does not say
    :param chosen: ``depth``, ``reliability`` and ``durability`` by pattern of topics
    :raises ParameterError: if it makes no sense
    """

    #: What each may be, in ROS 2's own words.
    ALLOWED = {
        "reliability": ("reliable", "best_effort"),
        "durability": ("volatile", "transient_local"),
    }

    def __init__(self, depth: int, chosen: Any) -> None:
        self._depth = depth
        self._chosen: Dict[str, Mapping[str, Any]] = {}
        if chosen is not None and not isinstance(chosen, dict):
            raise ParameterError("qos", chosen, "a mapping of topics")
        for pattern, choice in (chosen or {}).items():
            self._chosen["/" + pattern.lstrip("/")] = _judged(pattern, choice)

    def of(
        self,
        topic: str,
        latched: bool = False,
        best_effort: bool = False,
        at_least: int = 0,
    ) -> Quality:
        """Return the quality of a topic.

        :param latched: whether messages are kept for those who come later, unless the user says
        :param best_effort: whether messages may be lost, unless the user says
        :param at_least: how many messages are kept where it is latched
        """
        found: List[Mapping[str, Any]] = [
            choice
            for pattern, choice in self._chosen.items()
            if fnmatch.fnmatchcase(topic, pattern)
        ]
        choice = found[0] if found else {}
        if "durability" in choice:
            latched = choice["durability"] == "transient_local"
        if "reliability" in choice:
            best_effort = choice["reliability"] == "best_effort"
        depth = max(1, at_least) if at_least else self._depth
        return Quality(int(choice.get("depth", depth)), latched, best_effort)


def _judged(pattern: str, choice: Any) -> Mapping[str, Any]:
    if not isinstance(choice, dict):
        choice = {"": choice}
    for name, value in choice.items():
        allowed = Qualities.ALLOWED.get(name)
        if allowed is not None and value in allowed:
            continue
        if name == "depth" and type(value) is int and 1 <= value <= 100_000:
            continue
        words = f"one of {', '.join(allowed)}" if allowed else "1 to 100000"
        if allowed is None and name != "depth":
            words = "made of depth, reliability and durability"
        raise ParameterError(f"qos of {pattern}, {name}", value, words)
    return choice
