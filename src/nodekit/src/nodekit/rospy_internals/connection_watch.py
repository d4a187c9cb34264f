"""Warnings about publishers that subscribers of this process cannot connect to.

rospy logs neither an unreachable publisher nor a publisher that rejects the subscriber's message
type: the subscriber waits forever.
"""

import socket
import threading
import time
import traceback
from typing import Any, Callable, Dict, List, Set, Tuple
from urllib.parse import urlsplit

import rospy
import rospy.core
from rospy.impl.registration import get_topic_manager

#: Longest time from an announcement to a connection [s].
PATIENCE_S = 5.0
_PERIOD_S = 1.0
#: Timeout of the probe of a publisher that is not connected [s].
_PROBE_S = 2.0
#: Longest reason in a warning [characters]: rospy's reasons hold whole headers.
_LONGEST_REASON = 400


class ConnectionWatch:
    """Watch on announced publishers: warns once about each that is not connected in time.

    Its thread exists only while connections are missing.

    :param request: sends calls to the master and returns its replies; raises a ConnectionError if
        it does not reply in time
    """

    def __init__(self, request: Callable[[List[Tuple[Any, ...]]], List[Any]]) -> None:
        self._request = request
        self._lock = threading.Lock()
        #: Times of the announcements, by topic and URI of the publisher.
        self._missing: Dict[Tuple[str, str], float] = {}
        self._errors: Dict[Tuple[str, str], str] = {}
        self._reported: Set[Tuple[str, str]] = set()
        self._is_running = False

    def begin(self, topic: str, uri: str) -> None:
        """Expect a connection.

        :param topic: topic, resolved
        :param uri: URI of the publishing node
        """
        with self._lock:
            if (topic, uri) not in self._reported:
                self._missing.setdefault((topic, uri), time.monotonic())
                if not self._is_running:
                    threading.Thread(target=self._run, name="connections", daemon=True).start()
                    self._is_running = True

    def fail(self, topic: str, uri: str, error: object) -> None:
        """Keep the reason why a connection has failed.

        :param topic: topic, resolved
        :param uri: URI of the publishing node
        :param error: the reason
        """
        self._errors[topic, uri] = str(error)

    def _run(self) -> None:
        while True:
            time.sleep(_PERIOD_S)
            for (topic, uri), since in list(self._missing.items()):
                try:
                    if self._is_settled(topic, uri, since):
                        with self._lock:
                            del self._missing[topic, uri]
                            self._errors.pop((topic, uri), None)
                except (ConnectionError, ValueError):  # the master does not answer; retry later
                    pass
                except Exception:  # a topic that is being closed, for example
                    rospy.logdebug("%s", traceback.format_exc())
            with self._lock:
                if not self._missing:
                    self._is_running = False
                    return

    def _is_settled(self, topic: str, uri: str, since: float) -> bool:
        """Return whether to stop expecting a connection; warn if it is late."""
        subscribed = get_topic_manager().get_subscriber_impl(topic)
        if subscribed is None or rospy.core.is_shutdown_requested() or _is_linked(subscribed, uri):
            return True
        if time.monotonic() - since < PATIENCE_S:
            return False
        publisher = self._publisher(topic, uri)
        if publisher:
            self._reported.add((topic, uri))
            why = self._errors.get((topic, uri)) or _probe(uri)
            remedy = "check that node, and ROS_IP or ROS_HOSTNAME where it runs"
            if (
                "ROS_HOSTNAME=localhost" in why
            ):  # rospy's words: such a node connects to none beyond
                remedy = "set ROS_IP here to an address of this machine"
            elif "md5sum" in why or "type" in why:
                remedy = "use the same version of the message type on both sides"
            text = "topic %s: no connection to publisher %s at %s (%s); %s"
            rospy.logwarn(text, topic, publisher, uri, why[:_LONGEST_REASON], remedy)
        return True

    def _publisher(self, topic: str, uri: str) -> str:
        """Return the name of the node that publishes a topic at a URI; empty without one."""
        [(_, _, (publishers, _, _))] = self._request([("getSystemState",)])
        for node in dict(publishers).get(topic, []):
            [(code, _, found)] = self._request([("lookupNode", node)])
            if code == 1 and found == uri:
                return str(node)
        return ""


def _is_linked(subscribed: Any, uri: str) -> bool:
    """Return whether a subscribed topic gets the messages of a publisher."""
    is_direct = getattr(subscribed, "is_received_directly", lambda _uri: False)(uri)
    return is_direct or any(
        one.endpoint_id == uri and one.header is not None for one in subscribed.connections
    )


def _probe(uri: str) -> str:
    """Return why a node does not answer."""
    parts = urlsplit(uri)
    try:
        socket.create_connection((parts.hostname or "", parts.port or 0), _PROBE_S).close()
    except OSError as error:
        return str(error)
    return f"no answer within {PATIENCE_S:g} s"
