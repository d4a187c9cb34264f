"""Link to one board: synchronization and frames; one thread reads, one writes."""

import math
import threading
import time
import traceback
from typing import Any, Callable, Dict, List, Tuple

import rospy

from serial_link.framing.frames import OLD_REQUEST, PROBE, encode
from serial_link.hardware.ports import Port, PortLost, PortUnavailable
from serial_link.host import counters, sync_states
from serial_link.host.counters import Counters
from serial_link.host.message_queue import MessageQueue
from serial_link.host.parameter_requests import ParameterRequests
from serial_link.host.sync_monitor import SyncMonitor
from serial_link.link.events import LogLine, Message, ParameterRequest, Restarted, Synced, Topics
from serial_link.link.frame_reader import FrameReader
from serial_link.link.frame_writer import FrameWriter
from serial_link.link.throttled_log import ThrottledLog
from serial_link.negotiation import payloads
from serial_link.negotiation.payloads import FIRST_TOPIC, LOG, PARAMETER, TIME, TOPICS, TopicInfo
from serial_link.negotiation.topic_table import Endpoint, TopicTable

#: Longest wait for bytes [s]; shutdown is noticed after it.
_LONGEST_WAIT_S = 0.25
#: Longest wait for bytes while the board announces its topics [s].
_ROUND_POLL_S = 0.05
#: Most queued values of one latched topic: such topics are hardly ever streams, and the last value
#: is the valid one.
_LATCHED_DEPTH = 200
#: Most queued values of one topic on the way to ROS: they wait only on a busy machine.
_INBOX_DEPTH = 200
#: Interval of attempts to open a port, and of repeating the same log line [s].
_OPEN_EVERY_S, _LOG_EVERY_S = 0.2, 10.0
#: A board that has not answered for this long is logged [s], and from its second topic request on
#: it also receives the request of the old protocol.
_NO_ANSWER_S = 3.0
#: Time requests within this interval, which answer several probes, get one answer [s]: more would
#: fill the board's buffer.
_TIME_EVERY_S = 0.2
#: Size of a frame that announces a topic [bytes]; bits per byte on the line.
_TOPIC_BYTES, _BITS = 128, 10
#: Reason for dropping messages for a board that may not have been reset.
_LAPSED = (
    "the board was silent for 11 s, after which rosserial's library forgets its host: its topics "
    "are requested again; a loop must take less"
)
#: Returns the time for the board: seconds and nanoseconds.
TimeOf = Callable[[], Tuple[int, int]]


class BoardLink:
    """Link to a board at a port: synchronizes with it, and transfers its frames.

    The reader thread never blocks on its consumers: a received frame goes into a queue, unless it
    can be handled immediately. A frame to send goes into another queue, unless the line is free;
    the writer thread sends queued frames at the pace of the line.

    :param port: of the board; owned by this link
    :param counters: of traffic and faults
    :param time_of: returns the time for the board

    :ivar inbox: received events, see :mod:`.events`
    :ivar receive_now: function that is called with each message, and returns whether it has handled
        the message, which then does not go into the inbox. It must not block
    :ivar parameter_requests: which parameter request the board waits for
    """

    def __init__(self, port: Port, counters: Counters, time_of: TimeOf) -> None:
        self.inbox = MessageQueue(_INBOX_DEPTH)
        self.receive_now: Callable[[Endpoint, bytes], bool] = lambda endpoint, payload: False
        self.parameter_requests = ParameterRequests()
        self._port, self._counters, self._time_of = port, counters, time_of
        frame_s = _TOPIC_BYTES * _BITS / port.baud if port.baud else 0.0
        self._sync, self._topics = SyncMonitor(frame_s), TopicTable(frame_s)
        self._is_over = threading.Event()
        self._is_open = self._is_ending = self._is_request_due = False
        #: Why the port is not open, or the board does not answer; empty without a problem.
        self._trouble = ""
        self._throttled_log = ThrottledLog(_LOG_EVERY_S)
        self._reader = FrameReader(port)
        self._writer = FrameWriter(port, counters, self._throttled_log)
        self._outgoing_queue = self._writer.queue
        self._spoke_at = 0.0
        self._time_told_at = -math.inf
        self._restarts = 0
        #: Whether the board was started, and not all of its topics are known yet.
        self._is_new = True
        self._threads = [
            threading.Thread(target=self._guard, args=(work,), name=name, daemon=True)
            for work, name in ((self._read, "reader"), (self._writer.write_next, "writer"))
        ]

    def start(self) -> None:
        """Start the threads."""
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """Stop the threads, and close the port."""
        self._is_over.set()
        self._writer.close()
        for thread in self._threads:
            if thread.ident is not None:
                thread.join(2.0 * _LONGEST_WAIT_S)
        self._writer.close_port()  # waits for a frame that another thread is writing
        self._port.release()

    @property
    def port_name(self) -> str:
        """Name of the port."""
        return self._port.name

    @property
    def baud(self) -> int:
        """Bits a second of the line; 0 for a network connection."""
        return self._port.baud

    @property
    def is_synced(self) -> bool:
        """Whether the board is synchronized."""
        return self._sync.state in (sync_states.SYNCED, sync_states.SILENT, sync_states.PROBING)

    @property
    def trouble(self) -> str:
        """Why the board is not synchronized; empty if it is."""
        return "" if self.is_synced else self._trouble or "waiting for the board's answer"

    def all_counters(self) -> Dict[str, int]:
        """Return all counters by name."""
        faults = {f"fault: {kind}": count for kind, count in self._reader.faults.items()}
        return {
            **self._counters.to_dict(),
            **self._reader.traffic,
            **self._writer.traffic,
            **faults,
            "restarts of the board": self._sync.restarts,
            "dropped for newer ones, to the board": self._outgoing_queue.dropped,
            "dropped for newer ones, to ROS": self.inbox.dropped,
            "not kept": self._outgoing_queue.refused + self.inbox.refused,
        }

    def send(self, info: TopicInfo, payload: bytes) -> None:
        """Send a value of a stream; newer values may replace it in the queue.

        :param info: the board's description of the topic
        :param payload: the serialized message
        """
        self._send(info, payload, info.topic_id, 0)

    def send_latched(self, info: TopicInfo, payload: bytes) -> None:
        """Send a latched value; many may be queued at a time.

        :param info: the board's description of the topic
        :param payload: the serialized message
        """
        self._send(info, payload, (info.topic_id, "latched"), _LATCHED_DEPTH)

    def _send(self, info: TopicInfo, payload: bytes, stream: Any, depth: int) -> None:
        if not self._is_accepted(info):
            self._counters.add(counters.NO_CONTACT)
            return
        frame = encode(info.topic_id, payload)
        if not self._writer.write_now(frame):
            self._outgoing_queue.put(stream, frame, depth)

    def send_reliable(self, info: TopicInfo, payload: bytes) -> bool:
        """Send a message that must not be lost.

        :param info: the board's description of this half of the service
        :param payload: the serialized message
        :returns: whether it will be sent, unless the connection is lost
        """
        if not self._is_accepted(info):
            return False
        frame = encode(info.topic_id, payload)
        return self._writer.write_now(frame) or self._outgoing_queue.put_reliable(frame)

    def answer(self, topic_id: int, payload: bytes) -> None:
        """Answer a board that may not be synchronized yet.

        :param topic_id: a special id
        :param payload: the serialized message
        """
        if self._is_open:
            self._outgoing_queue.put_reliable(encode(topic_id, payload))

    def request_topics(self) -> None:
        """Request the topics of a synchronized board again, which ends a wait for a response."""
        self._is_request_due = True

    def send_stop(self) -> None:
        """Stop the board's publishing, because the host ends; return when the frame is sent."""
        self._is_ending = True
        self._writer.send_stop()

    def _is_accepted(self, info: TopicInfo) -> bool:
        """Return whether the board has subscribed to a topic since its last start.

        With another sketch, the same id may belong to another topic.
        """
        return self.is_synced and self._topics.accepts(info)

    def _guard(self, work: Callable[[], None]) -> None:
        """Repeat some work until the link is closed; log its exceptions."""
        while not self._is_over.is_set():
            try:
                work()
            except Exception:
                self._throttled_log.log(rospy.logerr, traceback.format_exc(), work.__name__)
                self._is_over.wait(_LONGEST_WAIT_S)

    def _read(self) -> None:
        """Open the port, or read once and handle timeouts."""
        now = time.monotonic()
        if not self._is_open:
            self.parameter_requests.poll(now)
            self._try_to_open()
            return
        due = self._sync.next_due()
        if not self._topics.is_settled:
            due = min(due, now + _ROUND_POLL_S)
        if self._is_ending:
            due = now + _LONGEST_WAIT_S
        try:
            data = self._port.read(max(0.0, min(due - now, _LONGEST_WAIT_S)))
        except PortLost as error:
            self._close_lost_port(error)
            return
        if self._is_ending:  # the board was stopped on purpose
            return
        now = time.monotonic()
        self.parameter_requests.poll(now)
        self._receive_bytes(now, data)
        if now >= due:
            self._execute(now, self._sync.poll(now))
        if self._is_request_due and self._topics.is_settled:  # a request begins the round again
            self._is_request_due = False
            if self.is_synced:
                self._execute(now, self._sync.ask(now))
        if not self._topics.is_settled:
            self._end_round(now)
        self._explain_silence(now)

    def _try_to_open(self) -> None:
        try:
            is_open = self._port.open(_OPEN_EVERY_S)
        except PortUnavailable as error:
            self._trouble = str(error)
            self._throttled_log.log(rospy.logwarn, str(error))
            self._is_over.wait(_OPEN_EVERY_S)
            return
        if not is_open:
            trouble = f"{self._port.name}: no board has connected yet"
            if not self._trouble:
                rospy.loginfo("%s", trouble)
            self._trouble = trouble
            return
        now = time.monotonic()
        self._throttled_log.reset()
        self._trouble = ""
        self._reader.open()
        self._spoke_at = now
        self._counters.add(counters.OPENINGS)
        at = f" at {self._port.baud} baud" if self._port.baud else ""
        rospy.loginfo("%s: open%s", self._port.name, at)
        self._is_open = True
        self._writer.open()
        self._execute(now, self._sync.handle(now, sync_states.OPENED))

    def _close_lost_port(self, error: PortLost) -> None:
        self._is_open = False
        self._writer.close_port()
        self._trouble = str(error)
        rospy.logwarn("%s", error)
        self._execute(time.monotonic(), self._sync.handle(time.monotonic(), sync_states.LOST))

    def _receive_bytes(self, now: float, data: bytes) -> None:
        """Handle received bytes, or a timeout without bytes."""
        frames, is_damaged = self._reader.receive(now, data)
        if is_damaged:
            self._topics.mark_damaged()
            self._execute(now, self._sync.handle(now, sync_states.DAMAGED))
        if frames:
            self._port.on_frame()
        for frame in frames:
            self._spoke_at = now
            self._handle_frame(now, *frame)

    def _handle_frame(self, now: float, topic_id: int, payload: bytes) -> None:
        try:
            if topic_id in TOPICS:
                event = sync_states.TOPIC
                self._add_topic(now, topic_id, payload)
            elif topic_id == TIME:
                event = sync_states.TIME
                self._send_time(now)
            elif topic_id == PARAMETER:
                event = sync_states.NOTICE
                name = payloads.decode_name(payload)
                number = self.parameter_requests.add(now)
                if self._sync.is_bare:  # the sketch has advertised nothing yet
                    self.inbox.put_reliable(Topics(self._topics.endpoints(), False))
                self.inbox.put_reliable(ParameterRequest(name, number))
            elif topic_id == LOG:
                event = sync_states.NOTICE
                self.inbox.put(LOG, LogLine(*payloads.decode_log(payload)))
            else:
                event = self._deliver(topic_id, payload)
        except payloads.PayloadError:
            self._counters.add(counters.MALFORMED)
            self._topics.mark_damaged()
            return
        actions = self._sync.handle(now, event)
        if actions:
            self._execute(now, actions)

    def _send_time(self, now: float) -> None:
        if now - self._time_told_at >= _TIME_EVERY_S:
            self._time_told_at = now
            answer = encode(TIME, payloads.encode_time(*self._time_of()))
            self._outgoing_queue.put_reliable(answer)

    def _add_topic(self, now: float, info_id: int, payload: bytes) -> None:
        info = payloads.decode_topic(payload)
        if not self._topics.add(now, info_id, info):
            self._throttled_log.log(
                rospy.logwarn, f"{self._port.name}: the board has too many topics"
            )

    def _deliver(self, topic_id: int, payload: bytes) -> str:
        endpoint = self._topics.incoming(topic_id)
        if endpoint is None:
            self._counters.add(counters.UNKNOWN_ID)
            # An id below FIRST_TOPIC is damage with valid checksums: no reason to request topics.
            return sync_states.UNKNOWN if topic_id >= FIRST_TOPIC else sync_states.NOTICE
        if self.receive_now(endpoint, payload):
            return sync_states.MESSAGE
        message = Message(endpoint, payload)
        if endpoint.is_service:
            self.inbox.put_reliable(message)
        else:
            self.inbox.put(topic_id, message)
        return sync_states.MESSAGE

    def _execute(self, now: float, actions: List[str]) -> None:
        for action in actions:
            if action == sync_states.ASK:
                self._counters.add(counters.ASKED)
                self._topics.begin_round(now, self.is_synced, self._sync.patience)
                self._outgoing_queue.put_reliable(encode(payloads.PUBLISHER, b""))
                if not self.is_synced and now - self._spoke_at > _NO_ANSWER_S:
                    self._outgoing_queue.put_reliable(OLD_REQUEST)
            elif action == sync_states.PROBE:
                self._outgoing_queue.put_reliable(PROBE)
            else:
                self._is_new = True
                self._topics.reset()
                self._outgoing_queue.clear()
                self._time_told_at = -math.inf
                self._report_restart()

    def _report_restart(self) -> None:
        why = self._trouble
        if self._is_open:
            was_reset = self._sync.restarts != self._restarts
            why = "the board was restarted" if was_reset else _LAPSED
            rospy.logwarn("%s: %s", self._port.name, why)
        self._restarts = self._sync.restarts
        self.inbox.put_reliable(Restarted(why))

    def _end_round(self, now: float) -> None:
        is_complete = self._topics.end_round(now)
        if is_complete is None or not self.is_synced:
            return
        if not is_complete:
            self._execute(now, self._sync.ask(now))
        self._reader.accept_up_to(self._topics.longest)
        self.inbox.put_reliable(Topics(self._topics.endpoints(), self._topics.is_complete))
        # Not earlier: a board does not read while it announces topics, and loses messages.
        if self._is_new and is_complete:
            self._is_new = False
            self.inbox.put_reliable(Synced())

    def _explain_silence(self, now: float) -> None:
        """Log a diagnosis if the board has not answered for long enough."""
        if self.is_synced or now - self._spoke_at < _NO_ANSWER_S:
            return
        self._trouble = self._reader.explain_silence()
        self._throttled_log.log(rospy.logwarn, f"{self._port.name}: {self._trouble}")
