"""Message from ROS 2, as the bridge takes it."""

from typing import NamedTuple, Optional


class ReceivedMessage(NamedTuple):
    """A message from ROS 2.

    :param data: its bytes
    :param sender: 16-byte id of the publisher
    :param number: its sequence number at that publisher; None without one
    """

    data: bytes
    sender: bytes
    number: Optional[int]
