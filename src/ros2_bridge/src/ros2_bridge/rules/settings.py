"""The user's settings: parameters of the bridge, and quality of service (QoS) of topics."""

import fnmatch
from typing import Any, List, Mapping, NamedTuple, Tuple

from nodekit import (
    BoolParameter,
    EnumParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    ParameterError,
    ParameterSet,
    StringParameter,
    read_once,
    rule,
)
from ros2_bridge.rules.selection import Rules
from ros2_bridge.rules.rates import MaxRates
from ros2_bridge.rules.renaming import Renaming


#: Longest duration in a quality of service [s]; unset means infinite.
_LONGEST_S = 86_400.0


class BridgeParameters(ParameterSet):
    """Parameters of the bridge."""

    direction = EnumParameter(
        "both",
        choices=("both", "to_ros2", "to_ros1"),
        help="direction of topics, services and actions",
    )
    allow = ListParameter(
        ("*",),
        element=StringParameter("", help="a pattern"),
        help="patterns of topics, services and actions that are bridged",
    )
    deny = ListParameter(
        (),
        element=StringParameter("", help="a pattern"),
        help="patterns of topics, services and actions that are not bridged",
    )
    remap = read_once(
        ListParameter(
            (),
            element=StringParameter("", help="a rule"),
            help="rules NAME=NAME, ROS 1 first: other name in ROS 2, also for all names below it",
        )
    )
    max_rate = ListParameter(
        (),
        element=StringParameter("", help="a rule"),
        help="rules PATTERN=HZ: maximum rates of topics",
    )
    parameters = BoolParameter(True, help="whether parameters are bridged")
    integers_for_doubles = BoolParameter(
        False,
        help="whether ROS 1 doubles accept an integer from ROS 2, which rclpy rejects",
    )
    depth = read_once(
        IntParameter(
            1000,
            minimum=1,
            maximum=100_000,
            help="history depth of each topic in ROS 2",
        )
    )
    max_nodes = IntParameter(
        100,
        minimum=0,
        maximum=1000,
        help="most ROS 1 nodes shown in ROS 2, and ROS 2 nodes with parameters in ROS 1",
    )
    service_timeout = FloatParameter(
        5.0,
        unit="s",
        above=0.0,
        maximum=3600.0,
        help="timeout for a service's response, or for a reaction to a goal",
    )

    @rule("remap")
    def remap_is_unambiguous(self) -> None:
        """Reject malformed rules, and several rules for a name."""
        self.names()

    @rule("max_rate")
    def max_rate_is_a_list_of_rules(self) -> None:
        """Reject malformed rules."""
        MaxRates(self.max_rate)

    def names(self) -> Renaming:
        """Return the renaming rules."""
        return Renaming(self.remap)

    def bridged(self, names: Renaming) -> Rules:
        """Return the rules for what is bridged.

        :param names: renaming rules
        """
        to_ros2, to_ros1 = self.direction != "to_ros1", self.direction != "to_ros2"
        return Rules(to_ros2, to_ros1, self.allow, self.deny, names, MaxRates(self.max_rate))


#: Most bytes that a publisher holds for a subscriber that does not read, unless the user sets a
#: depth, and that wait in a subscription: 1000 images would fill the memory.
HELD_BYTES = 2**26


class QosProfile(NamedTuple):
    """Quality of service (QoS) of a ROS 2 topic.

    :param depth: history depth
    :param latched: whether it is transient-local
    :param best_effort: whether messages may be lost
    :param offered: further policies of publishers, by their names in ``rclpy.qos.QoSProfile``:
        ``liveliness`` as text, the others in seconds. Subscriptions do not request them, so they
        match every publisher
    """

    depth: int
    latched: bool = False
    best_effort: bool = False
    offered: Tuple[Tuple[str, Any], ...] = ()


class QosProfiles:
    """Quality of service (QoS) of each topic: set by the user, or derived from other publishers.

    :param depth: default history depth
    :param chosen: list of mappings, each with a pattern of topics, ``topic``, and some of
        ``depth``, ``reliability``, ``durability``, ``deadline``, ``lifespan``, ``liveliness`` and
        ``liveliness_lease_duration``. (The parameter server does not accept slashes in names, so
        topics cannot be keys of a mapping.)
    :raises ParameterError: if it is malformed
    """

    #: Allowed values, in ROS 2's terms.
    ALLOWED = {
        "reliability": ("reliable", "best_effort"),
        "durability": ("volatile", "transient_local"),
        "liveliness": ("automatic", "manual_by_topic"),
    }
    #: Durations [s].
    DURATIONS = ("deadline", "lifespan", "liveliness_lease_duration")

    def __init__(self, depth: int, chosen: Any) -> None:
        self._depth = depth
        self._chosen: List[Mapping[str, Any]] = []
        if chosen is None:
            chosen = []
        for choice in chosen if isinstance(chosen, list) else [chosen]:
            if not isinstance(choice, dict) or not isinstance(choice.get("topic"), str):
                raise ParameterError("qos", choice, "a list of mappings, each with a topic")
            for name, value in choice.items():
                _validate(choice["topic"], name, value)
            self._chosen.append(choice)

    def of(
        self,
        topic: str,
        latched: bool = False,
        best_effort: bool = False,
        at_least: int = 0,
        size: int = 0,
    ) -> QosProfile:
        """Return the quality of a topic.

        :param latched: whether it is transient-local, unless the user sets it
        :param best_effort: whether messages may be lost, unless the user sets it
        :param at_least: minimum depth if it is transient-local
        :param size: size of its messages, which limits the depth unless the user sets it; 0 if
            unknown [bytes]
        """
        found = [one for one in self._chosen if fnmatch.fnmatchcase(topic, one["topic"])]
        choice = found[0] if found else {}
        if "durability" in choice:
            latched = choice["durability"] == "transient_local"
        if "reliability" in choice:
            best_effort = choice["reliability"] == "best_effort"
        depth = at_least or self._depth
        if size:
            depth = max(1, min(depth, HELD_BYTES // size))
        offered = (*self.DURATIONS, "liveliness")
        return QosProfile(
            int(choice.get("depth", depth)),
            latched,
            best_effort,
            tuple((name, choice[name]) for name in offered if name in choice),
        )


def _validate(topic: str, name: str, value: Any) -> None:
    allowed = QosProfiles.ALLOWED.get(name)
    if allowed is not None:
        is_good, words = value in allowed, f"one of {', '.join(allowed)}"
    elif name == "depth":
        is_good, words = type(value) is int and 1 <= value <= 100_000, "1 to 100000"
    elif name in QosProfiles.DURATIONS:
        is_good = type(value) in (int, float) and 0.0 < value <= _LONGEST_S
        words = f"a number of seconds above 0, at most {_LONGEST_S:g}"
    else:
        names = ("depth", *QosProfiles.ALLOWED, *QosProfiles.DURATIONS)
        is_good, words = name == "topic", f"made of topic, {', '.join(names)}"
    if not is_good:
        raise ParameterError(f"qos of {topic}, {name}", value, words)
