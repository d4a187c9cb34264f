"""Entry in getBusInfo, with counters, for a topic whose two ends are in the same process.

rospy counts and lists connections only, so ``getBusInfo`` and ``get_num_connections`` would report
a topic of two hosted nodes as unconnected.
"""

from typing import Any, Sequence, Sized

from rospy.impl.transport import Transport


class IntraprocessLink(Transport):
    """One end of a link within the process, with its counters.

    :param direction: ``INBOUND`` or ``OUTBOUND`` of ``rospy.impl.transport``
    :param endpoint: the other end as rospy lists it: the node's name, or its URI for a subscriber
    """

    #: As in roscpp.
    transport_type = "INTRAPROCESS"

    def __init__(self, direction: str, endpoint: str) -> None:
        super().__init__(direction)
        self.endpoint_id = endpoint

    def get_transport_info(self) -> str:
        """Return the description in ``getBusInfo``."""
        return "link within the process"

    def count(self, bodies: Sequence[Sized]) -> None:
        """Count messages that have passed.

        :param bodies: serialized messages
        """
        self.stat_num_msg += len(bodies)
        self.stat_bytes += sum(map(len, bodies))

    def bus_info(self, topic: str) -> Any:
        """Return the entry in ``getBusInfo``.

        :param topic: topic, resolved
        """
        info = self.get_transport_info()
        return self.id, self.endpoint_id, self.direction, self.transport_type, topic, True, info
