"""Events of a board link for the ROS side: topics, messages, log lines and restarts."""

from typing import List, NamedTuple, Union

from serial_link.negotiation.topic_table import Endpoint


class Topics(NamedTuple):
    """Topics of the board that are known since its start.

    :param endpoints: the topics
    :param is_complete: whether these are all, announced without damage
    """

    endpoints: List[Endpoint]
    is_complete: bool


class Message(NamedTuple):
    """A message, a request to a service, or a response."""

    endpoint: Endpoint
    payload: bytes


class ParameterRequest(NamedTuple):
    """The board asks for a parameter.

    :param name: of the parameter
    :param number: for :attr:`.BoardLink.parameter_requests`
    """

    name: str
    number: int


class LogLine(NamedTuple):
    """A line of the board's log."""

    level: int
    text: str


class Restarted(NamedTuple):
    """The board was restarted or lost: pending requests will not be answered."""

    why: str


class Synced(NamedTuple):
    """The board receives messages, and all of its topics since its start are known."""


Event = Union[Topics, Message, ParameterRequest, LogLine, Restarted, Synced]
