"""Periodic messages to the pages: frames with new samples, and heartbeats."""

import time
import traceback
from typing import List

import rospy
import tornado.ioloop

from nodekit import Throttle
from topic_scope.page.open_page import Page
from topic_scope.sampling.recorder import Recorder
from topic_scope.web.handlers import PageSocket

#: Period of frames [s].
FRAME_S = 0.025
#: Period of measurements [s], which cost as much as a dozen frames.
STATISTICS_S = 0.5
#: Period of heartbeats [s]; after 10 s without one, a page closes its connection.
ALIVE_S = 1.0
_LOG_PERIOD_S = 10.0


class FrameSender:
    """Sender of the pages' frames; runs in the web thread.

    :param recorder: recorder of the samples
    :param sockets: connections of the pages; the list may change

    :ivar has_samples: whether to send frames; otherwise pages receive only other messages
    """

    def __init__(self, recorder: Recorder, sockets: List[PageSocket]) -> None:
        self.has_samples = False
        self._recorder, self._sockets = recorder, sockets
        self._statistics_at = 0.0
        self._throttle = Throttle(_LOG_PERIOD_S)

    def start(self) -> None:
        """Start the periodic callbacks in the current loop."""
        tornado.ioloop.PeriodicCallback(self.send, FRAME_S * 1e3).start()
        tornado.ioloop.PeriodicCallback(self.send_alive, ALIVE_S * 1e3).start()

    def send_alive(self) -> None:
        """Send a heartbeat to each page that is ready."""
        for connection in self._sockets:
            if connection.is_ready:
                connection.send([{"type": "alive"}])

    def send(self) -> None:
        """Send a frame to each page that is ready and due."""
        now = self._recorder.update()
        is_to_measure = time.monotonic() >= self._statistics_at + STATISTICS_S
        if is_to_measure:
            self._statistics_at = time.monotonic()
        for connection in list(self._sockets):
            if connection.page is None:
                continue
            connection.page.is_to_measure |= is_to_measure
            try:
                if self.has_samples:
                    self._send_frame(connection, connection.page, now)
                elif connection.is_ready:
                    connection.send(connection.page.pop_messages())
            except Exception:  # the frames of other pages must not stop
                if self._throttle.is_due():
                    rospy.logerr("no frame: %s", traceback.format_exc())

    def _send_frame(self, connection: PageSocket, page: Page, now: float) -> None:
        page.watch(self._recorder, now)
        began, used = time.monotonic(), time.thread_time()
        if connection.is_ready and page.is_due(began):  # the next frame includes a skipped one
            measures, page.is_to_measure = page.is_to_measure, False
            connection.send(page.frame(self._recorder, now, measures))
            # CPU time: the load of other processes is not the page's cost.
            page.took(began, began + time.thread_time() - used)
