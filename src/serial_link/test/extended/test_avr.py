#!/usr/bin/env python3
"""Sketches as users write them, compiled, on an ATmega328P in simavr, and the node."""

import os
import subprocess
import time
from typing import Any, Dict, List

import rospy
import rostest
from helpers import avr_sketches
from helpers.avr_rig import PACKAGE, PATIENCE, AvrRig
from pid_control.msg import motor_input, motor_output
from std_msgs.msg import Float32, String, UInt16, UInt32
from std_srvs.srv import Trigger

from nodekit.testing.processes import Process, hanging
from nodekit.testing.waiting import wait_until
from serial_link.board.avr_board import AvrBoard
from serial_link.framing.frames import PROBE, encode
from serial_link.hardware.serial_port import SerialPort
from serial_link.negotiation.payloads import TIME

MOTOR_SKETCH = (
    PACKAGE.parents[1] / "docs" / "examples" / "board" / "motor_board" / "motor_board.ino"
)
#: Factor of the lower half of a command: an odd one, far from a power of 2.
CHECK = 40503
#: Commands for a loop, by its duration [ms].
COMMANDS = {1000: 8, 3000: 5, 5000: 4, 7000: 3, 12000: 1}
#: Bits of the numbers 0 to 24.
EACH_OF_25 = (1 << 25) - 1


def with_check(number: int) -> int:
    """Return a command with a number in its upper half, so that a wrong one shows."""
    return number << 16 | number * CHECK & 0xFFFF


class TestAvr(AvrRig):
    """Sketches of all kinds, resets, cables and noise."""

    def test_loops_of_1_to_12_s_lose_no_command(self) -> None:
        messages: Dict[int, List[Any]] = {}
        publishers: Dict[int, rospy.Publisher] = {}
        boards: Dict[int, AvrBoard] = {}
        sent = dict.fromkeys(COMMANDS, 0)
        seen = dict.fromkeys(COMMANDS, -1)
        for pause in COMMANDS:
            self.name = f"loop_{pause}"
            self.space, self.link = "/" + self.name, str(self.folder / self.name)
            messages[pause] = self.collect(f"{self.space}/heard", UInt16)
            publishers[pause] = rospy.Publisher(f"{self.space}/command", UInt16, queue_size=10)
            boards[pause] = self.start(avr_sketches.COUNTER + avr_sketches.WAITS % pause)

        def has_all() -> bool:
            for pause, count in COMMANDS.items():
                heard = len(messages[pause])
                is_connected = publishers[pause].get_num_connections() > 0
                if is_connected and sent[pause] < count and heard > seen[pause]:
                    seen[pause] = heard
                    publishers[pause].publish(0)
                    sent[pause] += 1
                if heard and messages[pause][-1].data == count:
                    boards[pause].close()
            return not any(board.is_running for board in boards.values())

        wait_until(has_all, lambda: f"{sent} {messages}", 2.0 * PATIENCE)

    def test_loop_that_logs_and_asks_for_parameters_is_found_again_after_a_reset(self) -> None:
        rospy.set_param(f"{self.space}/gain", 2.5)
        messages = self.collect(f"{self.space}/heard", UInt16)
        found = self.collect(f"{self.space}/found", Float32)
        publisher = rospy.Publisher(f"{self.space}/command", UInt16, queue_size=1)
        board = self.start(avr_sketches.COUNTER + avr_sketches.LOGS)

        def has_counted() -> bool:
            publisher.publish(0)
            return bool(found and messages and messages[-1].data >= 8)

        for boot_s in (0.0, 1.5):
            wait_until(has_counted, lambda: f"{messages} {found}", PATIENCE)
            assert found[-1].data == 2.5
            board.reset(boot_s)
            # The sketch that was restarted counts from 0.
            wait_until(lambda: messages[-1].data < 8, lambda: f"{messages[-3:]}", PATIENCE)
            found.clear()
        wait_until(lambda: found, lambda: f"{messages} {found}", PATIENCE)
        for level, text in (("INFO", "still here"), ("WARN", "warm"), ("ERROR", "hot")):
            self.nodes[self.space].wait_for_log(f"[{level}]", f"/board: {text}")

    def test_parameter_answered_late_is_not_taken_for_the_next_one(self) -> None:
        found = {}
        for name, value in (("first", 1.0), ("second", 2.0)):
            rospy.set_param(f"{self.space}/{name}", value)
            found[value] = self.collect(f"{self.space}/found/{name}", Float32)

        def wait_for_both() -> None:
            for messages in found.values():
                messages.clear()
            wait_until(lambda: all(found.values()), lambda: f"{found}", PATIENCE)

        self.start(avr_sketches.ASKS)
        for _ in range(2):
            wait_for_both()
            with hanging(self.nodes[self.space].popen.pid):
                time.sleep(1.5)  # meanwhile a request times out on the board, and others follow
            wait_for_both()
            wait_for_both()
            for value, messages in found.items():
                assert {message.data for message in messages} == {value}, found

    def test_refused_service_does_not_block_the_sketch_that_calls_it(self) -> None:
        service = rospy.Service(f"{self.space}/answers", Trigger, lambda _: (True, ""))
        self.addCleanup(service.shutdown)
        messages = self.collect(f"{self.space}/heard", UInt16)
        self.start(avr_sketches.CALLS)
        wait_until(lambda: messages and messages[-1].data >= 5, lambda: f"{messages}", PATIENCE)
        node = self.nodes[self.space]
        node.wait_for_log("differs is refused, and the board's calls end with an unchanged")
        assert len(node.logged("differs is refused")) == 1

    def test_topics_advertised_after_the_connection_appear(self) -> None:
        messages = self.collect(f"{self.space}/heard", UInt16)
        publisher = rospy.Publisher(f"{self.space}/command", UInt16, queue_size=1, latch=True)
        publisher.publish(7)
        self.start(avr_sketches.LATE)
        wait_until(lambda: messages and messages[-1].data == 7, lambda: f"{messages}", PATIENCE)

    def test_board_stops_publishing_when_the_node_ends(self) -> None:
        messages = self.collect(f"{self.space}/heard", UInt16)
        self.start(avr_sketches.LATE)
        wait_until(lambda: messages, lambda: "it is not heard", PATIENCE)
        node = self.nodes[self.space]
        assert node.interrupt() == 0
        port, answers = SerialPort(self.link, 57600), bytearray()
        assert port.open(0.0)
        self.addCleanup(port.release)

        def is_stopped() -> bool:  # only a board that waits for a host answers each probe
            port.write(PROBE)
            answers.extend(port.read(0.1))
            return 3 * encode(TIME, bytes(8)) in answers

        # By itself it would notice after 11 s.
        wait_until(is_stopped, lambda: f"{bytes(answers)!r}, {node.logged()}", 8.0)

    def test_25_topics_each_way_work_before_and_after_a_reset(self) -> None:
        messages = {
            number: self.collect(f"{self.space}/to/p{number}", UInt32) for number in range(25)
        }
        for number in range(25):
            topic = f"{self.space}/from/p{number}"
            publisher = rospy.Publisher(topic, UInt32, queue_size=1, latch=True)
            self.addCleanup(publisher.unregister)
            publisher.publish(number)
        board = self.start(avr_sketches.MANY)
        for _ in range(2):
            wait_until(
                lambda: all(messages.values()) and messages[0][-1].data == EACH_OF_25,
                lambda: f"{[one[-1:] for one in messages.values()]}",
                PATIENCE,
            )
            for number in range(1, 25):
                assert {message.data for message in messages[number]} == {number}
            board.reset()
            for of_topic in messages.values():
                of_topic.clear()
            # The sketch that was restarted has received none.
            wait_until(
                lambda: any(message.data != EACH_OF_25 for message in messages[0]),
                lambda: f"{messages[0]}",
                PATIENCE,
            )

    def test_texts_up_to_the_buffer_size_arrive_and_longer_ones_are_logged(self) -> None:
        messages = self.collect(f"{self.space}/heard", UInt16)
        echoes = self.collect(f"{self.space}/echo", String)
        publisher = rospy.Publisher(f"{self.space}/text", String, queue_size=10)
        self.start(avr_sketches.LENGTHS, 250000)
        for length in (276, 277, 268, 5):  # of 280 bytes, four are the length

            def is_answered(wanted: int = length) -> bool:
                publisher.publish("x" * wanted)
                return any(message.data == wanted for message in messages) or wanted == 277

            wait_until(is_answered, lambda: f"{messages}", PATIENCE)
        assert {message.data for message in messages} == {276, 268, 5}
        wait_until(
            lambda: {len(message.data) for message in echoes} == {268, 5}, lambda: f"{echoes[-1:]}"
        )
        self.nodes[self.space].wait_for_log("281 bytes is not sent: the board's buffer has 280")

    def test_noise_either_way_delivers_no_wrong_value_and_the_board_is_back(self) -> None:
        messages = self.collect(f"{self.space}/heard", UInt32)
        publisher = rospy.Publisher(f"{self.space}/command", UInt32, queue_size=1)
        counters = self.collect_counters()
        board = self.start(avr_sketches.ECHO)
        sent = 0

        def send() -> None:
            nonlocal sent
            sent += 1
            publisher.publish(with_check(sent & 0xFFFF))

        def damaged() -> int:
            names = ("length checksum", "length", "checksum", "cut off")
            return sum(counters.get("fault: " + name, 0) for name in names)

        def echoes(first: int) -> bool:
            send()
            return any(message.data >> 16 > first for message in messages)

        wait_until(lambda: echoes(0), lambda: f"{messages[-3:]}", PATIENCE)
        for share, count in ((0.001, 3), (0.01, 20), (0.05, 60)):
            before = damaged()
            board.set_noise(share)

            def is_damaged(wanted: int = before + count) -> bool:
                send()
                return damaged() >= wanted

            wait_until(is_damaged, lambda: f"{counters}", PATIENCE)
        board.set_noise(0.0)
        first = sent
        wait_until(lambda: echoes(first), lambda: f"{messages[-3:]}", PATIENCE)
        # About one in a thousand damaged frames has valid checksums all the same.
        values = {message.data for message in messages}
        wrong = [value for value in values if value != with_check(value >> 16)]
        assert len(wrong) <= 2 + damaged() / 100, wrong

    def test_cable_out_and_in_while_the_sketch_runs_and_with_a_reset(self) -> None:
        messages = self.collect(f"{self.space}/heard", UInt32)
        publisher = rospy.Publisher(f"{self.space}/command", UInt32, queue_size=1)
        board = self.start(avr_sketches.ECHO)
        for number, boot_s in ((1, -1.0), (2, -1.0), (3, 1.5)):

            def is_echoed(wanted: int = with_check(number)) -> bool:
                publisher.publish(wanted)
                return any(message.data == wanted for message in messages)

            wait_until(is_echoed, lambda: f"{messages[-3:]}", PATIENCE)
            board.unplug()
            node = self.nodes[self.space]
            wait_until(
                lambda: len(node.logged("is gone")) == number, lambda: f"{node.logged()}", PATIENCE
            )
            assert not os.path.lexists(self.link)
            board.plug()
            if boot_s >= 0.0:
                board.reset(boot_s)  # as by the line DTR
            messages.clear()
        wait_until(lambda: messages, lambda: f"{node.logged()}", PATIENCE)
        values = {message.data for message in messages}
        assert all(value == with_check(value >> 16) for value in values), values

    def test_reset_in_the_middle_of_a_message_delivers_none_that_is_damaged(self) -> None:
        messages = self.collect(f"{self.space}/heard", String)
        board = self.start(avr_sketches.FLOOD)

        def numbers() -> List[int]:
            return [int(message.data.split()[0]) for message in list(messages)]

        for boot_s in (0.0, 0.003, 0.4):
            wait_until(lambda: len(messages) > 20, lambda: f"{messages[-2:]}", PATIENCE)
            board.reset(boot_s)
            # The sketch that was restarted counts from 0.
            wait_until(lambda: numbers() != sorted(numbers()), lambda: f"{numbers()}", PATIENCE)
            assert all(message.data[5:] == f" {0:090}" for message in messages)
            messages.clear()

    def test_wrong_names_are_refused_by_name_and_a_slash_too_many_is_not(self) -> None:
        messages = self.collect(f"{self.space}/chatter", rospy.AnyMsg)
        self.start(avr_sketches.WRONG)
        node = self.nodes[self.space]
        wait_until(lambda: messages, lambda: f"{node.logged()}", PATIENCE)
        for name in ("my-topic", "1st", "unreadable"):
            node.wait_for_log(name, "refused")

    def test_motor_at_the_pins_of_the_node_follows_its_input(self) -> None:
        outputs = self.collect(f"{self.space}/motor_output", motor_output)
        publisher = rospy.Publisher(f"{self.space}/motor_input", motor_input, queue_size=1)
        words = [f"__ns:={self.space}", f"_link:={self.link}"]
        board = Process(str(PACKAGE / "scripts" / "avr_board.py"), words)
        self.addCleanup(board.end)
        self.start_node(115200)
        self.wait_for_connections(publisher)
        half = 13.1 * 128 / 255
        for share, speed in ((0.5, half), (1.0, 13.0), (-0.5, -half), (-1.0, -13.0)):

            def turns(wanted: float = speed, given: float = share) -> bool:
                publisher.publish(motor_input(input=given))
                speeds = [output.output for output in outputs[-50:]]
                means = sum(speeds[:25]) / 25, sum(speeds[25:]) / 25  # not in passing
                return len(speeds) == 50 and all(abs(one - wanted) < 0.06 for one in means)

            wait_until(turns, lambda: f"{outputs[-1:]}", PATIENCE)
        board.interrupt()
        assert not os.path.islink(self.link)

    def test_sketch_of_the_tutorial_fits_into_an_uno(self) -> None:
        program = self.builder.sketch(MOTOR_SKETCH, self.libraries)
        size = self.builder.size(program)
        assert 4000 < size.flash < 32256 and 1000 < size.ram < 2048, size
        for words, status, text in (
            ([program], 2, "usage: avr_board SKETCH.elf LINK"),
            ([program, "/nowhere/board"], 1, "avr_board: link: No such file or directory"),
        ):
            done = subprocess.run(
                [str(self.simulator), *map(str, words)], stderr=subprocess.PIPE, timeout=PATIENCE
            )
            assert (done.returncode, done.stderr.decode()) == (status, text + "\n")


if __name__ == "__main__":
    rospy.init_node("test_avr")
    rostest.rosrun("serial_link", "test_avr", TestAvr)
