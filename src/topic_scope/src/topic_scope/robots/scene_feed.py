"""Feed of the robots' scene to the pages that show it."""

from typing import Any, Dict, Mapping, Optional, Set, Tuple

import rospy

from nodekit import Throttle
from topic_scope.messages.layout_cache import Layouts
from topic_scope.messages.message_reader import MessageReader
from topic_scope.page.open_page import Page
from topic_scope.sampling.message_source import Batch, MessageSource
from topic_scope.robots import scene
from topic_scope.timing.nanoseconds import NS

#: Update period [s]; and number of updates between messages about static parts.
PERIOD_S, _SLOWLY = 0.05, 5
_LOG_PERIOD_S = 60.0


class SceneFeed:
    """Producer of the robot view; subscribes only while a page shows it.

    All methods are for the web thread.

    :param source: source of messages
    :param layouts: layouts of the messages

    :ivar pages: pages that show it
    """

    def __init__(self, source: MessageSource, layouts: Layouts) -> None:
        self._source = source
        self._layouts = layouts
        self._readers: Dict[Tuple[str, str], Optional[MessageReader]] = {}
        self._scene = scene.Scene()
        self._topics: Mapping[str, str] = {}
        self.pages: Set[Page] = set()
        self._sent: Dict[str, Dict[str, Any]] = {}
        self._ticks = 0
        self._throttle = Throttle(_LOG_PERIOD_S)

    # --- From the source ---------------------------------------------------------------------

    def set_topics(self, types: Mapping[str, str]) -> None:
        """Update the topics, and request those that the scene shows.

        :param types: type of each
        """
        self._topics = {}
        if self.pages:
            self._topics = {topic: one for topic, one in types.items() if self._is_shown(one)}
            self._scene.keep(self._topics)
        self._source.want(list(self._topics))

    def forget(self) -> None:
        """Drop all messages: the clock has jumped."""
        self._scene = scene.Scene()

    def _is_shown(self, datatype: str) -> bool:
        if datatype in scene.TYPES or datatype.endswith("/RobotStatus"):
            return True
        return scene.is_status(self._layouts.installed(datatype))

    def update(self) -> None:
        """Process new messages, and update pages; to be called every PERIOD_S."""
        if not self.pages:
            return
        now = self._source.clock.now()
        for topic, subscription in self._source.subscriptions().items():
            for batch in subscription.drain():
                self._add_batch(topic, batch)
        self.send_to_pages(self._scene.moving(now))
        self._ticks += 1
        if self._ticks % _SLOWLY == 0:
            self.send_to_pages(self._scene.standing(now))
            self.send_to_pages(self._scene.fleet(now))

    def _add_batch(self, topic: str, batch: Batch) -> None:
        reader = self._reader(batch.header)
        datatype = batch.header.get("type", "")
        if reader is None or topic not in self._topics or not self._is_known(batch.header):
            return
        since = 0 if datatype in scene.CUMULATIVE else -1
        for data, when in zip(batch.messages[since:], batch.times[since:]):
            try:
                self._scene.add_message(topic, datatype, reader.read(data), when / NS)
            except (LookupError, TypeError, ValueError) as error:
                if self._throttle.is_due(topic):
                    why = f"unexpected fields of {datatype}: {error!r}"
                    rospy.logwarn("%s is left out of the robot view: %s", topic, why)

    def _is_known(self, header: Mapping[str, str]) -> bool:
        return header["type"] in scene.TYPES or scene.is_status(self._layouts.received(header))

    def _reader(self, header: Mapping[str, str]) -> Optional[MessageReader]:
        key = (header.get("type", ""), header.get("md5sum", ""))
        if key not in self._readers:
            layout = self._layouts.received(header)
            self._readers[key] = MessageReader(layout) if layout is not None else None
        return self._readers[key]

    # --- Pages -------------------------------------------------------------------------------

    def send_to_pages(self, message: Dict[str, Any]) -> None:
        """Send a message to all pages that show robots, if it has changed."""
        if self._sent.get(message["type"]) != message:
            self._sent[message["type"]] = message
            for page in self.pages:
                page.put(message)

    def enter(self, page: Page) -> None:
        """Start to show robots on a page."""
        self.pages.add(page)
        for message in self._sent.values():
            page.put(message)

    def leave(self, page: Page) -> None:
        """Stop showing robots on a page."""
        self.pages.discard(page)
        if not self.pages:
            self._sent.clear()  # outdated when the next page enters
