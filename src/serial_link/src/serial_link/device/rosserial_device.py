"""Simulated rosserial client library: device side of the protocol, for a Python sketch."""

from typing import Dict, List, NamedTuple, Protocol, Sequence, Tuple

from serial_link.device import device_states
from serial_link.device.receiver import Receiver
from serial_link.framing.frames import encode
from serial_link.negotiation import payloads
from serial_link.negotiation.payloads import (
    LOG,
    PARAMETER,
    PUBLISHER,
    SERVICE_CLIENT,
    SERVICE_SERVER,
    STOP,
    SUBSCRIBER,
    TIME,
    TopicInfo,
)

#: First ids of the board's subscribers and publishers.
_FIRST_SUBSCRIBER, _FIRST_PUBLISHER = 100, 125
#: Interval of time requests, and the timeout after which the host counts as lost [s].
TIME_EVERY_S, HOST_LOST_S = 2.5, 11.0


class Endpoint(NamedTuple):
    """A topic or a service of a sketch.

    :param kind: PUBLISHER, SUBSCRIBER, SERVICE_SERVER or SERVICE_CLIENT
    :param name: of the topic or service
    :param type: of the message or service
    :param md5sum: of the message, or of the service's request
    :param answer_md5sum: md5sum of the service's response
    """

    kind: int
    name: str
    type: str
    md5sum: str
    answer_md5sum: str = ""


class Sketch(Protocol):
    """Sketch that runs on a board. Times are the board's [s]."""

    @property
    def topics(self) -> Sequence[Endpoint]:
        """The sketch's topics and services, in order."""
        ...

    def on_message(self, device: "Device", now: float, name: str, payload: bytes) -> None:
        """Handle a message, a request to a service of the board, or a response to its call."""
        ...

    def on_parameter(self, device: "Device", now: float, values: payloads.ParameterValues) -> None:
        """Handle a requested parameter."""
        ...

    def loop(self, device: "Device", now: float) -> None:
        """Run one iteration of the loop."""
        ...

    def next_due(self, now: float) -> float:
        """Return when :meth:`loop` next has work [s]."""
        ...


class Device:
    """Board's side of rosserial's protocol. Time is an argument [s].

    :param sketch: the sketch to run
    :param input_size: largest message that it receives [bytes]
    :param output_size: longest frame that it sends [bytes]
    :param wrong_md5: name of a topic for which it announces a wrong md5sum, as if its header was
        generated from another message

    :ivar state: of :mod:`.device_states`
    :ivar host_time: the last received host time [s]
    :ivar receiver: its frame receiver
    """

    def __init__(
        self, sketch: Sketch, input_size: int = 512, output_size: int = 512, wrong_md5: str = ""
    ) -> None:
        self.state = device_states.WAITING
        self.host_time = 0.0
        self.receiver = Receiver(input_size)
        self._sketch = sketch
        self._sizes = (output_size, input_size)
        self._output = bytearray()
        self._time_requested_at = self._host_seen_at = 0.0
        self._announcements: List[Tuple[int, TopicInfo]] = []
        self._outgoing: Dict[str, int] = {}
        self._incoming: Dict[int, str] = {}
        for endpoint in sketch.topics:
            self._add(endpoint, endpoint.name == wrong_md5)

    @property
    def is_configured(self) -> bool:
        """Whether the host knows its topics, so that it may publish."""
        return self.state == device_states.CONFIGURED

    def publish(self, name: str, payload: bytes) -> None:
        """Send a message, a request or a response; ignored while it is not configured.

        :param name: of the topic or service
        :param payload: the serialized message
        """
        if self.is_configured:
            self._send(self._outgoing[name], payload)

    def log(self, level: int, text: str) -> None:
        """Send a log line."""
        self._send(LOG, payloads.encode_log(level, text))

    def request_parameter(self, name: str) -> None:
        """Request a parameter."""
        self._send(PARAMETER, payloads.encode_name(name))

    def receive(self, now: float, data: bytes) -> None:
        """Handle received bytes."""
        before = self.receiver.other_versions
        frames = self.receiver.receive(now, data)
        for _ in range(self.receiver.other_versions - before):
            self._handle(now, device_states.OTHER_VERSION)
        for topic_id, payload in frames:
            event = {
                PUBLISHER: device_states.TOPICS_REQUESTED,
                TIME: device_states.TIME_RECEIVED,
                STOP: device_states.STOP_RECEIVED,
            }.get(topic_id, device_states.MESSAGE)
            self._handle(now, event, topic_id, payload)

    def loop(self, now: float) -> None:
        """Run one iteration of the loop, as Arduino's ``loop`` does."""
        if now - self._host_seen_at >= HOST_LOST_S:
            self._handle(now, device_states.HOST_LOST)
        if now - self._time_requested_at >= TIME_EVERY_S:
            self._handle(now, device_states.TIME_DUE)
        self._sketch.loop(self, now)

    def next_due(self, now: float) -> float:
        """Return when :meth:`loop` next has work [s]."""
        return min(self._sketch.next_due(now), max(now, self._time_requested_at) + TIME_EVERY_S)

    def output(self) -> bytes:
        """Take the bytes to send."""
        data = bytes(self._output)
        self._output.clear()
        return data

    def _add(self, endpoint: Endpoint, is_wrong: bool) -> None:
        kind, name, datatype, md5sum, answer = endpoint
        if is_wrong:
            md5sum = md5sum[::-1]
        # md5sum of the messages that the board sends: of its own service, those of the response.
        sent = answer if kind == SERVICE_SERVER else md5sum
        received = answer if kind == SERVICE_CLIENT else md5sum
        if kind != SUBSCRIBER:
            number = _FIRST_PUBLISHER + len(self._outgoing)
            self._outgoing[name] = number
            info = TopicInfo(number, name, datatype, sent, self._sizes[0])
            self._announcements.append((kind + PUBLISHER, info))
        if kind != PUBLISHER:
            number = _FIRST_SUBSCRIBER + len(self._incoming)
            self._incoming[number] = name
            info = TopicInfo(number, name, datatype, received, self._sizes[1])
            info_id = SUBSCRIBER if kind == SUBSCRIBER else kind + SUBSCRIBER
            self._announcements.append((info_id, info))

    def _handle(self, now: float, event: str, topic_id: int = 0, payload: bytes = b"") -> None:
        self.state, actions = device_states.find_transition(self.state, event)
        if event == device_states.TOPICS_REQUESTED:
            self._host_seen_at = now
        for action in actions:
            if action == device_states.ASK_TIME:
                self._time_requested_at = now
                self._send(TIME, payloads.encode_time(0, 0))
            elif action == device_states.NEGOTIATE:
                for info_id, info in sorted(self._announcements, key=lambda one: one[0] % 2):
                    self._send(info_id, payloads.encode_topic(info))
            elif action == device_states.SET_TIME:
                self._host_seen_at = now
                seconds, nanoseconds = payloads.decode_time(payload)
                self.host_time = seconds + 1e-9 * nanoseconds
            elif topic_id == PARAMETER:
                self._sketch.on_parameter(self, now, payloads.decode_values(payload))
            elif topic_id in self._incoming:
                self._sketch.on_message(self, now, self._incoming[topic_id], payload)

    def _send(self, topic_id: int, payload: bytes) -> None:
        frame = encode(topic_id, payload)
        if len(frame) <= self._sizes[0]:
            self._output += frame
        elif topic_id != LOG:
            self.log(payloads.ERROR, "Message from device dropped: message larger than buffer.")
