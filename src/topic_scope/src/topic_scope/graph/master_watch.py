"""Thread that polls the master's registrations each second, and subscribes to the shown topics."""

import threading
import traceback
from typing import Any, Callable, List, Mapping, NamedTuple, Tuple

import rosgraph
import rospy

from nodekit import Throttle
from nodekit.master import MasterClient
from topic_scope.messages.layout_cache import Layouts
from topic_scope.sampling.raw_subscriptions import RawSubscriptions

#: Polling period [s].
PERIOD_S = 1.0
_LOG_PERIOD_S = 60.0

Registrations = List[Tuple[str, List[str]]]


class GraphState(NamedTuple):
    """Snapshot of the master's registrations.

    :param publishers: topics and the nodes that publish them
    :param subscribers: topics and the nodes that subscribe to them
    :param services: services and the nodes that offer them
    :param types: type of each topic
    """

    publishers: Registrations
    subscribers: Registrations
    services: Registrations
    types: Mapping[str, str]

    @property
    def published_types(self) -> Mapping[str, str]:
        """Type of each topic that has a publisher."""
        return {topic: self.types.get(topic, "*") for topic, nodes in self.publishers if nodes}


class MasterWatch:
    """Thread that polls the master once a second, and opens the requested subscriptions.

    :param subscriptions: subscriptions to the shown topics
    :param layouts: loaded in this thread, because it takes time
    """

    def __init__(self, subscriptions: RawSubscriptions, layouts: Layouts) -> None:
        self._subscriptions = subscriptions
        self._layouts = layouts
        self._master = MasterClient(rospy.get_name(), rospy.get_node_uri())
        self._wake = threading.Event()
        self._throttle = Throttle(_LOG_PERIOD_S)

    def start(
        self, on_state: Callable[[GraphState], Any], on_silence: Callable[[str], Any]
    ) -> None:
        """Start the thread.

        :param on_state: called with each state, from the thread
        :param on_silence: called likewise with the master's URI at each failed poll
        """
        arguments = (on_state, on_silence)
        threading.Thread(target=self._run, args=arguments, name="master", daemon=True).start()

    def refresh(self) -> None:
        """Poll the master immediately."""
        self._wake.set()

    def _run(self, on_state: Callable[[GraphState], Any], on_silence: Callable[[str], Any]) -> None:
        while not rospy.is_shutdown():
            try:
                self._subscriptions.adjust()
                publishers, subscribers, services = self._master.system_state()
                types = self._master.topic_types()
                for datatype in set(types.values()):
                    self._layouts.installed(datatype)
                on_state(GraphState(publishers, subscribers, services, types))
            except (OSError, rospy.ROSException) as error:  # MasterUnreachable is an OSError
                rospy.logdebug("the master does not answer: %s", error)
                on_silence(rosgraph.get_master_uri())
            except Exception:  # keep the thread alive: it is the only source of updates
                if self._throttle.is_due():
                    rospy.logerr("the graph: %s", traceback.format_exc())
            self._wake.wait(PERIOD_S)
            self._wake.clear()
