"""Registrations of this process with the master, restored when the master loses them.

The master loses all of them in a restart, or by ``rosnode cleanup``. A service belongs to the node
that registered it last: when that node ends, the master lists no node for the service, and this
process has to register it again.
"""

from typing import List, Optional, Set

import rospy

from nodekit.master import MasterClient, Reading
from nodekit.rospy_internals import registration_listener
from nodekit.rospy_internals.registration_listener import with_owners
from nodekit.round_robin import RoundRobin

#: Most services that are looked up at a time; more are looked up by round robin.
LOOKUPS = 20


class MasterRegistrations:
    """Registrations of this process with the master.

    :param client: client of the master

    :ivar are_lost: whether everything has to be registered again
    """

    def __init__(self, client: MasterClient) -> None:
        self.are_lost = False
        self._client = client
        self._master_pid: Optional[int] = None
        self._is_another = False
        #: Whether the master rejected everything, so that it does not know this node.
        self._is_refused = False
        self._taken: Set[str] = set()
        self._round_robin = RoundRobin(LOOKUPS)

    def begin(self, reading: Reading) -> None:
        """Store the process id of the master."""
        self._master_pid = reading.master_pid

    def detect_loss(self, reading: Reading) -> None:
        """Detect a restarted master, or one that no longer knows this node."""
        if self._master_pid not in (None, reading.master_pid):
            self.are_lost = self._is_another = True
        elif not reading.knows_node and not self._is_refused:
            self.are_lost = True
        self._master_pid = reading.master_pid

    def reregister(self) -> None:
        """Register all topics and services again.

        :raises MasterUnreachable: if the master does not answer
        """
        self._is_refused = not registration_listener.reregister_all(self._client.request)

    def log_reregistered(self) -> None:
        """Log that everything is registered again."""
        why = "was restarted" if self._is_another else "had forgotten this node"
        self.are_lost = self._is_another = False
        if not self._is_refused:
            rospy.logwarn("the master %s: registered again, settings in force are kept", why)

    def reclaim_services(self) -> None:
        """Register services again that another node took over and no longer offers.

        :raises MasterUnreachable: if the master does not answer
        """
        services = registration_listener.services()
        turn = self._round_robin.next(list(services))
        if not turn:
            return
        free: List[str] = []
        taken: List[str] = []
        answers = self._client.request([("lookupService", name) for name in turn])
        for name, (code, _, uri) in zip(turn, answers):
            if code != 1:
                free.append(name)
            elif uri == services[name]:
                self._taken.discard(name)
            elif name not in self._taken:
                taken.append(name)
        if taken:
            text = "taken over by another node, which is now called instead: service %s"
            rospy.logwarn(text, with_owners(taken, self._client.request))
            self._taken.update(taken)
        if free and not self.are_lost:
            registration_listener.register_services(free, self._client.request)
            self._taken.difference_update(free)
            rospy.loginfo(
                "no longer offered by any node, registered again: service %s", ", ".join(free)
            )
