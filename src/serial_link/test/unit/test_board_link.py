"""The link's threads and a board at the other end of a real pseudo terminal, without ROS."""

import logging
import math
import pathlib
import socket
import threading
import time
from types import SimpleNamespace
from typing import Any, Iterator, List, Optional, Sequence

import pytest

from nodekit.testing.processes import free_port
from nodekit.testing.waiting import TIMEOUT_S, in_thread, wait_until
from serial_link.board.transports import PtyTransport
from serial_link.board.simulation import Faults, SimulatedBoard
from serial_link.device.rosserial_device import Device, Endpoint
from serial_link.framing.frames import OLD_REQUEST, encode
from serial_link.hardware.serial_port import SerialPort
from serial_link.hardware.tcp_port import TcpServer
from serial_link.hardware.tcp_slots import parse_slots
from serial_link.host.counters import Counters
from serial_link.host.message_queue import DEPTH, MOST_KEPT, MessageQueue
from serial_link.host.sync_monitor import OVERDUE_S, QUIET_S
from serial_link.host.sync_states import (
    ASK,
    ASKED,
    OPENED,
    PROBING,
    RESTART,
    SEEKING,
    SILENT,
    SYNCED,
    TOPIC,
)
from serial_link.link import board_link
from serial_link.link.events import (
    LogLine,
    Message,
    ParameterRequest,
    Restarted,
    Synced,
    Topics,
)
from serial_link.link.board_link import BoardLink
from serial_link.link.throttled_log import ThrottledLog
from serial_link.negotiation.payloads import (
    INFO,
    LOG,
    PARAMETER,
    PUBLISHER,
    SERVICE_SERVER,
    SUBSCRIBER,
    TIME,
    ParameterValues,
    TopicInfo,
    encode_log,
    encode_name,
    encode_time,
    encode_topic,
)
from serial_link.negotiation.topic_table import MOST_ROUNDS, SETTLED_S

BAUD = 115200


def topic_info(number: int, name: str, size: int = 512) -> TopicInfo:
    return TopicInfo(number, name, "std_msgs/Empty", "d" * 32, size)


def drain(queue: MessageQueue) -> List[Any]:
    """Take all messages out of a queue."""
    return list(iter(lambda: queue.get(0.0), None))


class Talker:
    """Sketch with many topics, which publishes on one of them continuously."""

    topics: Sequence[Endpoint] = tuple(
        Endpoint(kind, f"topic_{kind}_{number}", "std_msgs/Empty", "d" * 32)
        for kind in (PUBLISHER, SUBSCRIBER)
        for number in range(8)
    )

    def __init__(self) -> None:
        self.heard: List[bytes] = []
        self.device: Optional[Device] = None
        #: Whether to send a message of a topic that was not announced.
        self.strange = False
        #: Whether it sends log lines and parameter requests instead of messages.
        self.logs = False

    def on_message(self, device: Device, now: float, name: str, payload: bytes) -> None:
        self.heard.append(payload)

    def on_parameter(self, device: Device, now: float, values: ParameterValues) -> None:
        pass

    def loop(self, device: Device, now: float) -> None:
        self.device = device
        if self.strange:
            self.strange = False
            device._send(140, b"")
        if self.logs:
            device.log(INFO, "still here")
            device.request_parameter("gain")
        else:
            device.publish("topic_0_0", b"")

    def next_due(self, now: float) -> float:
        return now + 0.001


class Rig:
    """A link and a board."""

    def __init__(self, folder: pathlib.Path) -> None:
        self.sketch = Talker()
        path = str(folder / "board")
        self.end = PtyTransport(path)
        self.board = SimulatedBoard(self.end, BAUD, lambda now: Device(self.sketch), 0.05)
        self.times = iter(range(1, 10**6))
        self.link = BoardLink(SerialPort(path, BAUD), Counters(), self.time)
        self.arrived: List[Any] = []

    def time(self) -> "tuple[int, int]":
        return next(self.times), 0

    def start(self) -> None:
        self.board.start()
        self.link.start()

    def fetch_until(self, kind: type) -> Any:
        """Fetch events up to the next of a type."""

        def is_there() -> bool:
            arrival = self.link.inbox.get(0.1)
            if arrival is not None:
                self.arrived.append(arrival)
            return isinstance(arrival, kind)

        wait_until(is_there, lambda: f"no {kind.__name__} among {self.arrived[-3:]}")
        return self.arrived[-1]


@pytest.fixture
def rig(tmp_path: pathlib.Path) -> Iterator[Rig]:
    """Return a link and a board, to be started."""
    made = Rig(tmp_path)
    yield made
    made.link.close()
    made.board.close()


def test_reading_continues_while_inbox_is_full(rig: Rig) -> None:
    rig.start()
    wait_until(
        lambda: rig.link.all_counters()["dropped for newer ones, to ROS"] > 0,
        lambda: "nothing waits",
    )
    # The board asks for the time again 2.5 s later; it is told, though the inbox is full.
    wait_until(
        lambda: rig.sketch.device is not None and rig.sketch.device.host_time >= 2.0,
        lambda: "no time",
    )


def test_topics_are_requested_over_bad_cable_until_all_are_known(
    rig: Rig,
) -> None:
    rig.board.faults = Faults(noise=0.01)
    rig.start()
    wanted = {endpoint.name for endpoint in Talker.topics}

    def is_all() -> bool:
        topics = rig.fetch_until(Topics)
        return wanted <= {endpoint.name for endpoint in topics.endpoints}

    wait_until(is_all, lambda: f"{rig.link.all_counters()}")
    assert rig.link.all_counters()["asked"] > 1


def test_messages_pass_in_both_directions(rig: Rig) -> None:
    rig.start()
    assert rig.link.trouble and not rig.link.is_synced
    topics = rig.fetch_until(Topics)
    assert len(topics.endpoints) == len(Talker.topics)
    rig.fetch_until(Synced)
    assert rig.fetch_until(Message).endpoint.name == "topic_0_0"
    assert rig.link.is_synced and rig.link.trouble == ""
    infos = {endpoint.name: endpoint.outgoing for endpoint in topics.endpoints}
    assert rig.link.send_reliable(infos["topic_1_0"], b"all")
    rig.link.send(infos["topic_1_1"], b"one")
    wait_until(lambda: rig.sketch.heard == [b"all", b"one"], lambda: f"{rig.sketch.heard}")
    figures = rig.link.all_counters()
    assert figures["openings"] == 1 and figures["restarts of the board"] == 0


def test_messages_that_are_handled_immediately_do_not_go_into_the_inbox(rig: Rig) -> None:
    handled: List[str] = []

    def handle(endpoint: Any, payload: bytes) -> bool:
        handled.append(endpoint.name)
        return len(handled) > 1

    rig.link.receive_now = handle
    rig.start()
    rig.fetch_until(Message)
    wait_until(lambda: len(handled) > 20, lambda: f"{handled}")
    left = [rig.link.inbox.get(0.0) for _ in range(20)]
    assert set(handled) == {"topic_0_0"}
    assert not any(isinstance(event, Message) for event in left)


def test_messages_without_board_are_counted_and_loss_is_logged(
    rig: Rig, caplog: "pytest.LogCaptureFixture"
) -> None:
    rig.start()
    info = rig.fetch_until(Topics).endpoints[-1].outgoing
    rig.fetch_until(Synced)
    rig.board.faults = Faults(is_plugged=False)
    assert "is gone" in rig.fetch_until(Restarted).why and "is gone" in caplog.text
    wait_until(lambda: "does not exist" in rig.link.trouble, lambda: rig.link.trouble)
    rig.link.send(info, b"")
    assert not rig.link.send_reliable(info, b"")
    assert rig.link.all_counters()["no contact"] == 1
    rig.board.faults = Faults()
    rig.fetch_until(Synced)
    assert rig.link.all_counters()["openings"] == 2


def test_unknown_topics_are_requested_and_restart_reported_only_when_lost(
    rig: Rig,
) -> None:
    rig.start()
    rig.fetch_until(Synced)
    rig.sketch.strange = True
    rig.arrived.clear()
    rig.fetch_until(Topics)
    rig.fetch_until(Message)
    assert not any(isinstance(arrival, Synced) for arrival in rig.arrived)
    assert rig.link.all_counters()["unknown id"] == 1 and rig.link.all_counters()["asked"] == 2
    rig.board.reset()
    assert "restarted" in rig.fetch_until(Restarted).why
    rig.fetch_until(Synced)


def test_board_that_was_reset_boots_for_its_present_boot_time(rig: Rig) -> None:
    rig.board.start()
    wait_until(lambda: rig.board.device is not None, lambda: "it does not start")
    rig.board.boot_s = TIMEOUT_S
    rig.board.reset()
    wait_until(lambda: rig.board.device is None, lambda: "it does not boot")


def test_board_that_logs_in_its_loop_is_found_again_after_a_reset(rig: Rig) -> None:
    rig.start()
    rig.fetch_until(Synced)
    rig.sketch.logs = True
    rig.board.reset()
    assert "restarted" in rig.fetch_until(Restarted).why
    rig.fetch_until(Synced)
    assert rig.sketch.device is not None and rig.sketch.device.is_configured


def test_board_that_was_silent_for_too_long_is_not_called_restarted(
    rig: Rig, caplog: "pytest.LogCaptureFixture"
) -> None:
    rig.link._is_open = True
    for action in rig.link._sync.handle(0.0, OPENED):
        rig.link._execute(0.0, [action])
    rig.link._sync.handle(0.1, TOPIC)
    while rig.link._sync.next_due() < OVERDUE_S + 1.0:
        now = rig.link._sync.next_due()
        rig.link._execute(now, rig.link._sync.poll(now))
        if rig.link._sync.state == ASKED:
            break
    assert "the board was silent for 11 s" in rig.fetch_until(Restarted).why
    assert "a loop must take less" in caplog.text and "was restarted" not in caplog.text
    assert rig.link.all_counters()["restarts of the board"] == 0


def test_frame_that_an_adapter_holds_back_is_not_lost_but_one_that_is_cut_off_ends(
    rig: Rig,
) -> None:
    frame = encode(LOG, encode_log(INFO, "held back"))
    rig.link._receive_bytes(1.0, frame[:9])
    rig.link._receive_bytes(1.45, b"")
    rig.link._receive_bytes(1.46, frame[9:])
    assert rig.link.inbox.get(0.0) == LogLine(INFO, "held back")
    rig.link._receive_bytes(2.0, frame[:9])
    rig.link._receive_bytes(2.61, b"")
    assert rig.link.all_counters()["fault: cut off"] == 1


@pytest.mark.parametrize(
    ("data", "counter"),
    [
        (encode(PUBLISHER, b"x"), "malformed"),
        (encode(PUBLISHER, b"x")[:-1] + b"x", "fault: checksum"),
    ],
)
def test_malformed_or_damaged_announcement_requires_another_round(
    rig: Rig, data: bytes, counter: str
) -> None:
    rig.link._topics.begin_round(1.0)
    rig.link._receive_bytes(1.0, data)
    assert rig.link.all_counters()[counter] == 1
    assert rig.link._topics.end_round(9.0) is False


def test_topics_are_requested_again_if_the_answer_may_have_been_damaged(rig: Rig) -> None:
    rig.link._sync.state = SEEKING
    rig.link._receive_bytes(1.0, b"damaged")
    assert rig.link._sync.state == ASKED and rig.link.all_counters()["asked"] == 1
    rig.link._sync.state = SEEKING
    rig.link._sync._asked_at = -math.inf
    rig.link._receive_bytes(2.0, encode(LOG, encode_log(INFO, "good")))
    assert rig.link._sync.state == SEEKING
    rig.link._receive_bytes(3.0, b"damaged" + encode(LOG, encode_log(INFO, "good")))
    assert rig.link._sync.state == ASKED


@pytest.mark.parametrize(
    ("frame", "state"),
    [
        (encode(PUBLISHER, encode_topic(TopicInfo(126, "new", "a/B", "d" * 32, 512))), SYNCED),
        (encode(125, b""), SYNCED),
        (encode(200, b""), SYNCED),
        (encode(TIME, bytes(8)), PROBING),
        (encode(LOG, encode_log(INFO, "text")), SILENT),
        (encode(PARAMETER, encode_name("gain")), SILENT),
        (encode(99, b""), SILENT),
    ],
)
@pytest.mark.parametrize("is_handled", [False, True])
def test_frame_of_a_silent_board_proves_what_only_a_configured_board_sends(
    rig: Rig, frame: bytes, state: str, is_handled: bool
) -> None:
    rig.link.receive_now = lambda endpoint, payload: is_handled
    rig.link._topics.add(1.0, PUBLISHER, topic_info(125, "speed"))
    rig.link._sync.state = SILENT
    rig.link._receive_bytes(2.0, frame)
    assert rig.link._sync.state == state


def test_topics_of_a_damaged_round_are_incomplete_and_the_board_not_yet_synced(rig: Rig) -> None:
    rig.link._sync.state = SYNCED
    rig.link._topics.begin_round(1.0)
    rig.link._topics.mark_damaged()
    rig.link._end_round(2.0)
    assert drain(rig.link.inbox) == [Topics([], False)]
    rig.link._topics._rounds = MOST_ROUNDS  # no further round, although topics may be missing
    rig.link._topics.mark_damaged()
    rig.link._end_round(9.0)
    assert drain(rig.link.inbox) == [Topics([], False), Synced()]


def test_round_without_an_answer_makes_no_board_synced(rig: Rig) -> None:
    rig.link._sync.state = SEEKING
    rig.link._topics.begin_round(1.0)
    rig.link._end_round(9.0)
    assert rig.link._topics.is_settled and drain(rig.link.inbox) == []


@pytest.mark.parametrize("answer", [[], [encode(TIME, bytes(8))]])
def test_board_that_answers_without_topics_can_get_its_parameters(
    rig: Rig, answer: List[bytes]
) -> None:
    rig.link._sync.handle(1.0, OPENED)
    rig.link._receive_bytes(1.1, b"".join([*answer, encode(PARAMETER, encode_name("gain"))]))
    known = [Topics([], False)] if answer else []
    assert drain(rig.link.inbox) == [*known, ParameterRequest("gain", 1)]


def test_surplus_topic_is_logged(
    rig: Rig, monkeypatch: "pytest.MonkeyPatch", caplog: "pytest.LogCaptureFixture"
) -> None:
    monkeypatch.setattr("serial_link.negotiation.topic_table.MOST_TOPICS", 0)
    rig.link._receive_bytes(1.0, encode(PUBLISHER, encode_topic(topic_info(125, "speed"))))
    assert "the board has too many topics" in caplog.text


def test_only_an_unknown_id_of_a_topic_requests_the_topics(rig: Rig) -> None:
    rig.link._sync.state = SYNCED
    asked = []
    for topic_id in (99, 100):
        rig.link._receive_bytes(1.0, encode(topic_id, b""))
        asked.append(rig.link.all_counters().get("asked", 0))
    assert asked == [0, 1]


def test_frame_beyond_the_announced_buffers_is_damage(rig: Rig) -> None:
    rig.link._sync.state = SYNCED
    rig.link._topics.begin_round(1.0)
    rig.link._topics.add(1.0, PUBLISHER, topic_info(125, "speed", 64))
    rig.link._end_round(2.0)
    rig.link._receive_bytes(3.0, encode(125, bytes(57)))
    assert rig.link.all_counters()["fault: length"] == 1


def test_board_with_a_slow_loop_has_time_for_its_announcements(rig: Rig) -> None:
    rig.link._sync._loop_s = 5.0
    rig.link._execute(1.0, [ASK])
    assert rig.link._topics.end_round(6.0) is None


def test_messages_and_calls_of_a_topic_that_falls_behind_displace_no_others(rig: Rig) -> None:
    add = rig.link._topics.add
    add(1.0, PUBLISHER, topic_info(125, "speed"))
    add(1.0, PUBLISHER, topic_info(126, "button"))
    add(1.0, SERVICE_SERVER, topic_info(127, "zero"))
    add(1.0, SERVICE_SERVER + SUBSCRIBER, topic_info(100, "zero"))
    calls = board_link._INBOX_DEPTH + 1
    rig.link._receive_bytes(1.0, encode(126, b""))
    rig.link._receive_bytes(1.0, calls * (encode(125, b"") + encode(127, b"")))
    names = [message.endpoint.name for message in drain(rig.link.inbox)]
    assert [names.count(name) for name in ("speed", "button", "zero")] == [1, 1, calls]


def test_dropped_and_refused_messages_are_counted_by_direction(rig: Rig) -> None:
    lines = board_link._INBOX_DEPTH + 1
    data = lines * encode(LOG, encode_log(INFO, "hot"))
    rig.link._receive_bytes(1.0, data)
    for _ in range(DEPTH + 1):
        rig.link._outgoing_queue.put("speed", b"")
    for queue, surplus in ((rig.link.inbox, 1), (rig.link._outgoing_queue, 2)):
        for _ in range(MOST_KEPT + surplus):
            queue.put_reliable(b"")
    figures = rig.link.all_counters()
    assert figures["dropped for newer ones, to ROS"] == lines - 1
    assert figures["dropped for newer ones, to the board"] == DEPTH
    assert figures["not kept"] == 3
    assert (figures["received"], figures["received bytes"]) == (lines, len(data))


def test_stream_displaces_no_latched_message_of_its_topic(rig: Rig) -> None:
    rig.link._sync.state = SYNCED
    rig.link._topics.add(1.0, SUBSCRIBER, topic_info(100, "told"))
    for _ in range(DEPTH + 1):
        rig.link.send_latched(topic_info(100, "told"), b"latched")
        rig.link.send(topic_info(100, "told"), b"stream")
    waiting = drain(rig.link._outgoing_queue)
    assert waiting.count(encode(100, b"latched")) == DEPTH + 1
    assert waiting.count(encode(100, b"stream")) == 1


@pytest.mark.parametrize("state", [SYNCED, SILENT, PROBING])
def test_board_gets_messages_while_it_is_probed(rig: Rig, state: str) -> None:
    rig.link._sync.state = state
    rig.link._topics.add(1.0, SUBSCRIBER, topic_info(100, "told"))
    assert rig.link.send_reliable(topic_info(100, "told"), b"") and rig.link.trouble == ""
    drain(rig.link._outgoing_queue)
    before = topic_info(100, "of the sketch before")
    assert not rig.link.send_reliable(before, b"")
    rig.link.send(before, b"")
    rig.link.send_latched(before, b"")
    assert rig.link.all_counters()["no contact"] == 2
    assert drain(rig.link._outgoing_queue) == []


def test_restart_drops_what_was_for_the_board_before(rig: Rig) -> None:
    rig.link._is_open = True
    rig.link._topics.add(1.0, PUBLISHER, topic_info(125, "speed"))
    rig.link._receive_bytes(1.0, encode(TIME, bytes(8)))
    rig.link._sync.restarts = 1
    rig.link._execute(1.1, [RESTART])
    assert rig.link._topics.endpoints() == [] and drain(rig.link._outgoing_queue) == []
    rig.link._receive_bytes(1.1, encode(TIME, bytes(8)))  # its clock is at zero again
    assert len(drain(rig.link._outgoing_queue)) == 1
    rig.link._execute(30.0, [RESTART])
    first, second = (arrival.why for arrival in drain(rig.link.inbox))
    assert first == "the board was restarted" and "silent for 11 s" in second


def test_answer_for_a_board_that_is_gone_does_not_wait_for_the_next_one(rig: Rig) -> None:
    rig.link.answer(PARAMETER, b"")
    assert drain(rig.link._outgoing_queue) == []


def test_old_protocol_is_tried_only_with_a_board_that_does_not_answer(rig: Rig) -> None:
    request = encode(PUBLISHER, b"")
    rig.link._spoke_at = 1.0
    sent = []
    for now, state in ((1.0, ASKED), (5.0, ASKED), (9.0, SYNCED)):
        rig.link._sync.state = state
        rig.link._execute(now, [ASK])
        sent.append(drain(rig.link._outgoing_queue))
    assert sent == [[request], [request, OLD_REQUEST], [request]]


def test_silence_is_explained_only_for_a_board_that_is_not_synced(
    rig: Rig, monkeypatch: "pytest.MonkeyPatch", caplog: "pytest.LogCaptureFixture"
) -> None:
    monkeypatch.setattr(rig.link._port, "read", lambda timeout: b"")
    monkeypatch.setattr(board_link, "time", SimpleNamespace(monotonic=lambda: 100.0))
    rig.link._is_open = True
    for state, count in ((SYNCED, 0), (SEEKING, 1)):
        rig.link._sync.state = state
        rig.link._read()
        assert caplog.text.count("the board sends nothing") == count
    assert f"at {BAUD} baud" in caplog.text
    assert rig.link.trouble.startswith("the board sends nothing")  # for /diagnostics
    assert caplog.records[-1].levelname == "WARNING"
    rig.link._receive_bytes(101.0, b"at another speed")
    rig.link._explain_silence(102.0)
    assert rig.link.trouble.startswith("the received bytes are not rosserial messages")


def test_stopped_board_is_no_longer_read(rig: Rig, monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr(rig.link._port, "read", lambda timeout: encode(140, b""))
    rig.link._is_open = True
    rig.link.send_stop()
    rig.link._read()
    assert rig.link.all_counters()["received"] == 0


def test_request_on_demand_is_dropped_while_the_board_is_not_synced(
    rig: Rig, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(rig.link._port, "read", lambda timeout: b"")
    rig.link._is_open = True
    asked = []
    for state in (ASKED, SYNCED):
        rig.link._sync.state = state
        rig.link.request_topics()
        rig.link._read()
        asked.append(rig.link.all_counters().get("asked", 0))
    assert asked == [0, 1]


def test_board_on_a_slow_line_has_time_for_its_answer_and_for_each_announcement(
    tmp_path: pathlib.Path,
) -> None:
    link = BoardLink(SerialPort(str(tmp_path / "board"), 2400), Counters(), lambda: (0, 0))
    link._topics.begin_round(1.0)
    info = TopicInfo(125, "speed", "std_msgs/Empty", "d" * 32, 512)
    link._receive_bytes(1.0, encode(PUBLISHER, encode_topic(info)))
    # An announcement takes half a second on the line.
    assert link._topics.end_round(1.0 + SETTLED_S + 0.5) is None
    assert link._sync.patience > QUIET_S + 0.5


def test_time_to_answer_starts_when_the_port_is_opened(
    rig: Rig, monkeypatch: "pytest.MonkeyPatch", caplog: "pytest.LogCaptureFixture"
) -> None:
    monkeypatch.setattr("serial_link.link.board_link._NO_ANSWER_S", TIMEOUT_S)
    caplog.set_level(logging.INFO, "rosout")
    rig.end.plug()
    rig.link._spoke_at = -math.inf  # the board was last heard long ago
    rig.link._trouble = "the port does not exist"
    rig.link._try_to_open()
    rig.link._explain_silence(time.monotonic())
    assert rig.link.trouble == "waiting for the board's answer"
    assert f"open at {BAUD} baud" in caplog.text


def test_longer_messages_than_those_of_the_previous_board_are_accepted(rig: Rig) -> None:
    rig.link._reader.accept_up_to(64)
    rig.link._receive_bytes(0.5, b"noise" + encode(LOG, encode_log(INFO, "cut off"))[:9])
    faults = rig.link.all_counters()
    rig.end.plug()
    rig.link._try_to_open()
    assert rig.link._reader.explain_silence().startswith("the board sends nothing")
    text = 100 * "x"
    rig.link._receive_bytes(1.0, encode(LOG, encode_log(INFO, text)))
    assert rig.link.inbox.get(0.0) == LogLine(INFO, text)
    for name in ("fault: checksum", "fault: cut off", "fault: garbage bytes"):
        assert rig.link.all_counters().get(name, 0) == faults.get(name, 0)


def test_parameter_request_that_arrived_during_a_pause_of_the_host_is_not_pending(
    rig: Rig, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    now, data = 100.0, b""
    monkeypatch.setattr(board_link, "time", SimpleNamespace(monotonic=lambda: now))
    monkeypatch.setattr(rig.link._port, "read", lambda timeout: data)
    rig.link._is_open = True
    rig.link._read()
    now, data = 102.0, encode(PARAMETER, encode_name("gain"))
    is_pending = []
    for _ in "ab":
        rig.link._read()
        number = rig.fetch_until(ParameterRequest).number
        is_pending.append(rig.link.parameter_requests.is_pending(now, number))
    assert is_pending == [False, True]


def test_absence_of_the_board_is_no_pause_of_the_host(
    rig: Rig, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    now = 100.0
    monkeypatch.setattr(board_link, "time", SimpleNamespace(monotonic=lambda: now))
    monkeypatch.setattr(rig.link._port, "open", lambda timeout: False)
    rig.link.parameter_requests.poll(now)
    for now in (100.5, 101.0):
        rig.link._read()
    rig.link.parameter_requests.poll(101.5)
    number = rig.link.parameter_requests.add(101.5)
    assert rig.link.parameter_requests.is_pending(101.5, number)


def test_simultaneous_time_requests_get_one_answer(rig: Rig) -> None:
    rig.link._receive_bytes(1.0, 5 * encode(TIME, bytes(8)))
    assert [rig.link._outgoing_queue.get(0.0) for _ in "ab"] == [
        encode(TIME, encode_time(1, 0)),
        None,
    ]
    rig.link._receive_bytes(1.5, encode(TIME, bytes(8)))
    assert rig.link._outgoing_queue.get(0.0) == encode(TIME, encode_time(2, 0))


def test_missing_board_is_logged_once_per_absence(
    rig: Rig, monkeypatch: "pytest.MonkeyPatch", caplog: "pytest.LogCaptureFixture"
) -> None:
    missing = "does not exist: is the board plugged in"
    rig.link._throttled_log = ThrottledLog(math.inf)  # time alone lifts no limit
    pauses: List[float] = []
    with monkeypatch.context() as changed:
        changed.setattr(rig.link._is_over, "wait", pauses.append)
        for _ in "ab":
            rig.link._try_to_open()
    assert caplog.text.count(missing) == 1 and pauses == [board_link._OPEN_EVERY_S] * 2
    rig.start()
    for losses in (2, 3):
        rig.board.faults = Faults()
        rig.fetch_until(Synced)
        rig.board.faults = Faults(is_plugged=False)
        wait_until(lambda: caplog.text.count(missing) == losses, lambda: caplog.text)


def test_wait_for_the_first_board_is_logged_once_with_the_address(
    caplog: "pytest.LogCaptureFixture",
) -> None:
    caplog.set_level(logging.INFO, "rosout")
    number = free_port()
    link = BoardLink(TcpServer("localhost", number).ports[0], Counters(), lambda: (0, 0))
    link._throttled_log = ThrottledLog(math.inf)  # time alone lifts no limit
    waits = f"tcp localhost:{number}: no board has connected yet"
    link.start()
    try:
        wait_until(lambda: waits in caplog.text, lambda: caplog.text)
        with socket.create_connection(("localhost", number)):
            wait_until(lambda: ": open" in caplog.text, lambda: caplog.text)
        wait_until(lambda: link.trouble == waits, lambda: link.trouble)
        assert caplog.text.count(waits) == 1 and " baud" not in caplog.text
    finally:
        link.close()


def test_an_exception_is_logged_and_ends_no_thread(
    rig: Rig, caplog: "pytest.LogCaptureFixture"
) -> None:
    failures = []

    def fail() -> "tuple[int, int]":
        failures.append(1)
        raise RuntimeError("no time today")

    rig.link._time_of = fail
    rig.start()
    wait_until(lambda: failures, lambda: "it was not asked for the time")
    rig.link._time_of = rig.time
    rig.fetch_until(Synced)
    assert "RuntimeError: no time today" in caplog.text


def test_request_on_demand_is_sent_once(rig: Rig) -> None:
    rig.start()
    rig.fetch_until(Synced)
    wait_until(lambda: rig.link._topics.is_settled, lambda: "the round does not end")
    asked = rig.link.all_counters()["asked"]
    rig.link.request_topics()
    wait_until(lambda: rig.link.all_counters()["asked"] > asked, lambda: "it is not asked")
    rig.fetch_until(Topics)
    assert rig.link.is_synced and rig.link.all_counters()["asked"] == asked + 1


def test_requests_on_demand_without_pause_let_a_round_end(rig: Rig) -> None:
    """As of a sketch that calls a service without a server in its loop."""
    is_over = threading.Event()

    def request() -> None:
        while not is_over.wait(0.01):
            rig.link.request_topics()

    thread = in_thread(request)
    try:
        rig.start()
        rig.fetch_until(Synced)
        rig.fetch_until(Topics)
    finally:
        is_over.set()
        thread.join()


def test_board_is_stopped_at_shutdown(rig: Rig) -> None:
    rig.start()
    rig.fetch_until(Synced)
    rig.link.send_stop()
    wait_until(
        lambda: rig.sketch.device is not None and not rig.sketch.device.is_configured,
        lambda: "it goes on",
    )
    rig.link.close()
    for thread in rig.link._threads:
        wait_until(lambda: not thread.is_alive(), lambda: f"{thread.name} goes on")


def test_address_of_a_connection_is_kept_from_its_first_frame_on() -> None:
    number, slots = free_port(), parse_slots("left,right")
    links = [
        BoardLink(port, Counters(), lambda: (0, 0))
        for port in TcpServer("localhost", number, slots).ports
    ]
    left = links[0]
    left.start()
    wait_until(lambda: left.trouble.endswith("no board has connected yet"), lambda: left.trouble)
    with socket.create_connection(("localhost", number)) as client:
        client.sendall(b"GET / HTTP/1.0\r\n\r\n")
        wait_until(lambda: left.all_counters().get("received bytes"), lambda: "nothing came")
        assert slots[0].peer == ""
        client.sendall(encode(TIME, b""))
        wait_until(lambda: slots[0].peer == "127.0.0.1", lambda: "it is not kept")
    for link in links:
        link.close()


def test_port_is_closed_after_the_frame_that_another_thread_writes(
    rig: Rig, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    rig.start()
    rig.fetch_until(Synced)
    order: List[str] = []
    release = rig.link._port.release
    monkeypatch.setattr(rig.link._port, "release", lambda: (order.append("released"), release()))
    monkeypatch.setattr(board_link, "_LONGEST_WAIT_S", 0.01)
    with rig.link._writer._port_lock:
        closing = in_thread(rig.link.close)
        closing.join(0.3)  # longer than close() waits for its own threads
        order.append("written")
    closing.join(30.0)
    assert order == ["written", "released"]
