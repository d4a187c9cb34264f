"""Numbers on the page of this package: those of the code."""

import pathlib

import pytest

from serial_link.device import motor_sketch
from serial_link.endpoints import log_lines, topics
from serial_link.framing import decoder
from serial_link.hardware import serial_port, tcp_port, tcp_slots
from serial_link.host import baud_pacing, message_queue, sync_monitor
from serial_link.link import board_link
from serial_link.nodes import serial_node

DOCS = pathlib.Path(__file__).resolve().parents[4] / "docs"
PAGE = " ".join((DOCS / "nodes" / "serial_link.md").read_text(encoding="utf-8").split())


@pytest.mark.parametrize(
    "sentence",
    [
        f"replaces its old connection {tcp_slots.SAME_BOARD_S:g} s after its last frame",
        f"a board with another address does so after {tcp_slots.OTHER_BOARD_S:g} s",
        f"A surplus board is refused after {tcp_port._SLOT_S:g} s",
        f"at most {log_lines._PER_SECOND} a second",
        f"up to {message_queue.DEPTH} of each topic",
        f"none is dropped before {message_queue.MOST_KEPT} wait",
        f"{board_link._LATCHED_DEPTH} messages of a latched topic may wait",
        f"If more than {board_link._INBOX_DEPTH} values of a topic wait",
        f"does not read, the newest {topics._MOST_HELD} are held",
        f"a frame that is incomplete after {baud_pacing.LONGEST_FRAME_MS} ms",
        f"The port is tried {({5: 'five'})[round(1.0 / board_link._OPEN_EVERY_S)]} times a second",
        f"After {serial_port._WRITE_S:g} s the message is dropped",
        f"After {tcp_port._WRITE_S:g} s the message is dropped",
        f"After {board_link._NO_ANSWER_S:g} s the log says what may be wrong",
        f"Without a time request for {sync_monitor.OVERDUE_S:g} s",
        f"after a fault or garbage, for {decoder.NOISY_FRAMES} frames",
        f"which proves that it is whole, or after {serial_port._GAP_S:g} s",
        f"logged in one line, at most every {serial_node._LINE_EVERY_S:g} s",
        f"0 to {motor_sketch.FULL_SCALE}, {1.0 / motor_sketch.POTENTIOMETER_EVERY_S:g} times",
        f"stopped when it was not driven for {motor_sketch.INPUT_TIMEOUT_S:g} s",
    ],
)
def test_page_has_the_number_of_the_code(sentence: str) -> None:
    assert sentence in PAGE
