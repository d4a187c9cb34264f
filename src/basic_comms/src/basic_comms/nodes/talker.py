"""The talker: publishes a text again and again."""

from typing import Dict, Optional

import rospy
from std_msgs.msg import String

from basic_comms.chatter.message_scope import SCOPES, as_text, candidates, message_text
from nodekit.live.live_parameters import LiveParameters
from nodekit.live.watcher import Observation, Watch, get_watcher
from nodekit.messaging.publisher import Publisher
from nodekit.messaging.stream_log import StreamLog
from nodekit.parameters.declaration import EnumParameter, FloatParameter, ParameterSet
from nodekit.parameters.no_value import MISSING
from nodekit.process.run import run
from nodekit.timing.scheduler import get_scheduler
from nodekit.timing.timetable import SLOWEST_HZ


class TalkerParameters(ParameterSet):
    """Private parameters of the talker."""

    rate = FloatParameter(
        10.0,
        minimum=SLOWEST_HZ,
        maximum=10000.0,
        unit="Hz",
        help="how often the text is published",
    )
    message_scope = EnumParameter(
        "closest",
        choices=SCOPES,
        help="where Message is looked up: in one namespace, or from the node's own outwards",
    )


class Message(Watch):
    """One place where the text may stand; its value is never written."""

    def __init__(self, key: str) -> None:
        super().__init__(key)
        self.text: Optional[str] = None

    def observe(self, seen: Observation) -> bool:
        """Take over the text; after a restart of the master keep the last one."""
        if not (seen.forgotten and seen.value is MISSING):
            self.text = as_text(seen.value) if seen.value is not MISSING else None
        return True


class Talker:
    """Publishes ``<Message> <ROS time>`` at a rate.

    :ROS Publishers:
        - ``chatter`` (std_msgs/String)

    :ROS Parameters:
        - those of :class:`TalkerParameters`, private
        - ``Message`` (any scalar), at ``~``, in the namespaces around the node
          and at ``/``: the text; read live, never written
    """

    def __init__(self) -> None:
        self._parameters = LiveParameters(TalkerParameters, exempt=["Message"])
        self._keys = candidates(rospy.get_name())
        self._messages = self._follow_messages()
        self._log = StreamLog()
        self._publisher = Publisher("chatter", String)
        self._task = get_scheduler().every(self._parameters.values.rate, self._publish)
        self._parameters.start(on_change=lambda new, old: self._task.set_rate(new.rate))

    def _follow_messages(self) -> Dict[str, Message]:
        watcher = get_watcher()
        messages = {key: Message(key) for key in self._keys}
        watcher.server.subscribe(self._keys)
        for key, raw in watcher.server.read(self._keys).values.items():
            messages[key].text = as_text(raw) if raw is not MISSING else None
            watcher.add(messages[key])
        return messages

    def _publish(self, _elapsed: float) -> None:
        found = {key: message.text for key, message in self._messages.items()}
        scope = self._parameters.values.message_scope
        text = "%s %s" % (message_text(found, self._keys, scope), rospy.get_time())
        self._log.line(text)
        self._publisher.publish(String(text))


def main() -> None:
    """Run the node until it is shut down."""
    run("talker", Talker)
