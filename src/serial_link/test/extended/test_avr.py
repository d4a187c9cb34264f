#!/usr/bin/env python3
"""Sketches as users write them, compiled, on an ATmega328P in simavr, and the node."""

import os
import pathlib
import shutil
import tempfile
import unittest
from typing import Any, List, Sequence

import rospkg
import rospy
import rostest
from pid_control.msg import motor_input, motor_output
from rosgraph_msgs.msg import Log
from std_msgs.msg import Float32, String, UInt16

from nodekit.testing.processes import Process
from nodekit.testing.waiting import wait_until
from serial_link.board.avr_board import AvrBoard, AvrBuilder
from serial_link.commands.make_headers import build_headers, write
from serial_link.headers.arduino_library import arduino_library

PACKAGE = pathlib.Path(rospkg.RosPack().get_path("serial_link"))
NODE = str(PACKAGE / "scripts" / "serial_node.py")
MOTOR_SKETCH = (
    PACKAGE.parents[1] / "docs" / "examples" / "board" / "motor_board" / "motor_board.ino"
)
#: Longest wait for a board [s]: on a busy machine the simulator falls behind.
PATIENCE = 60.0
#: Beginning of the tests' sketches, before the loop.
COUNTER = """
#include <ros.h>
#include <std_msgs/Float32.h>
#include <std_msgs/UInt16.h>

ros::NodeHandle host;
std_msgs::UInt16 count;
std_msgs::Float32 parameter;
ros::Publisher heard("heard", &count), found("found", &parameter);
void on_command(const std_msgs::UInt16 &message) { count.data++; }
ros::Subscriber<std_msgs::UInt16> command("command", on_command);

void setup() {
  host.initNode();
  host.advertise(heard);
  host.advertise(found);
  host.subscribe(command);
}
"""
WAITS = "void loop() { heard.publish(&count); host.spinOnce(); delay(%d); }"
LOGS = """
void loop() {
  if (host.getParam("gain", &parameter.data)) found.publish(&parameter);
  heard.publish(&count);
  host.loginfo("still here");
  host.spinOnce();
  delay(100);
}
"""
LATE = """
#include <ros.h>
#include <std_msgs/UInt16.h>

ros::NodeHandle host;
std_msgs::UInt16 count;
ros::Publisher heard("heard", &count);
void on_command(const std_msgs::UInt16 &message) { count.data = message.data; }
ros::Subscriber<std_msgs::UInt16> command("command", on_command);

void setup() {
  host.initNode();
  while (!host.connected()) host.spinOnce();
  host.subscribe(command);
  host.advertise(heard);
}

void loop() { heard.publish(&count); host.spinOnce(); delay(50); }
"""
FLOOD = """
#include <ros.h>
#include <std_msgs/String.h>

ros::NodeHandle host;
std_msgs::String text;
ros::Publisher heard("heard", &text);
char line[100];
uint16_t count;

void setup() {
  host.initNode();
  host.advertise(heard);
  text.data = line;
}

void loop() {
  sprintf(line, "%05u %090u", count, 0);
  if (heard.publish(&text) > 0) count++;
  host.spinOnce();
}
"""
#: The second topic is announced as by a library that reads its type from the wrong memory.
WRONG = """
#include <ros.h>
#include <std_msgs/Bool.h>

class Unreadable : public std_msgs::Bool {
 public:
  const char *getType() { return "\\x0e\\x94 std_msgs"; }
};

ros::NodeHandle host;
std_msgs::Bool value;
Unreadable garbage;
ros::Publisher dash("my-topic", &value), unreadable("unreadable", &garbage), digit("1st", &value),
    slash("chatter/", &value);

void setup() {
  host.initNode();
  host.advertise(dash);
  host.advertise(unreadable);
  host.advertise(digit);
  host.advertise(slash);
}

void loop() {
  dash.publish(&value);
  unreadable.publish(&garbage);
  digit.publish(&value);
  slash.publish(&value);
  host.spinOnce();
  delay(50);
}
"""


class TestAvr(unittest.TestCase):
    """Each test has its own board and node; the compiled programs are shared."""

    folder: pathlib.Path
    libraries: Sequence[pathlib.Path]
    simulator: pathlib.Path
    builder: AvrBuilder

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        headers = build_headers(["std_msgs", "pid_control"])
        write(arduino_library(headers, "the tests", "1.0.0"), cls.folder)
        cls.libraries = (PACKAGE / "avr" / "library", cls.folder / "ros_messages" / "src")
        cls.builder = AvrBuilder(cls.folder)
        cls.simulator = cls.builder.simulator(PACKAGE / "avr" / "avr_board.c")

    @classmethod
    def tearDownClass(cls) -> None:
        shutil.rmtree(cls.folder)

    def setUp(self) -> None:
        self.name = self.id().rsplit(".", 1)[-1]
        self.space = "/" + self.name
        self.link = str(self.folder / self.name)

    def start_node(self, baud: int) -> None:
        node = Process(NODE, [f"__ns:={self.space}", f"_port:={self.link}", f"_baud:={baud}"])
        self.addCleanup(node.end)

    def start(self, text: str) -> AvrBoard:
        """Run a sketch, and the node, until the end of the test."""
        sketch = self.folder / (self.name + ".ino")
        sketch.write_text(text)
        program = self.builder.sketch(sketch, self.libraries)
        board = AvrBoard(self.simulator, program, self.link)
        board.start()
        self.addCleanup(board.close)
        self.start_node(57600)
        return board

    def collect(self, topic: str, data_class: Any) -> List[Any]:
        """Return a list that receives a topic's messages."""
        messages: List[Any] = []
        subscriber = rospy.Subscriber(topic, data_class, messages.append)
        self.addCleanup(subscriber.unregister)
        return messages

    def wait_for_connections(self, publisher: rospy.Publisher) -> None:
        wait_until(lambda: publisher.get_num_connections() > 0, lambda: "no node", PATIENCE)

    def test_loop_that_waits_three_seconds_loses_no_command(self) -> None:
        messages = self.collect(f"{self.space}/heard", UInt16)
        publisher = rospy.Publisher(f"{self.space}/command", UInt16, queue_size=10)
        self.start(COUNTER + WAITS % 3000)
        self.wait_for_connections(publisher)
        for number in range(1, 4):
            publisher.publish(number)
            seen = len(messages)
            wait_until(lambda: len(messages) > seen, lambda: f"{messages}", PATIENCE)
        wait_until(lambda: messages[-1].data == 3, lambda: f"{messages}", PATIENCE)

    def test_loop_that_logs_and_asks_for_parameters_is_found_again_after_a_reset(self) -> None:
        rospy.set_param(f"{self.space}/gain", 2.5)
        messages = self.collect(f"{self.space}/heard", UInt16)
        found = self.collect(f"{self.space}/found", Float32)
        publisher = rospy.Publisher(f"{self.space}/command", UInt16, queue_size=1)
        board = self.start(COUNTER + LOGS)

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

    def test_topics_advertised_after_the_connection_appear(self) -> None:
        messages = self.collect(f"{self.space}/heard", UInt16)
        publisher = rospy.Publisher(f"{self.space}/command", UInt16, queue_size=1, latch=True)
        publisher.publish(7)
        self.start(LATE)
        wait_until(lambda: messages and messages[-1].data == 7, lambda: f"{messages}", PATIENCE)

    def test_reset_in_the_middle_of_a_message_delivers_none_that_is_damaged(self) -> None:
        messages = self.collect(f"{self.space}/heard", String)
        board = self.start(FLOOD)

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
        lines = self.collect("/rosout", Log)
        messages = self.collect(f"{self.space}/chatter", rospy.AnyMsg)
        self.start(WRONG)
        wait_until(lambda: messages, lambda: f"{lines[-3:]}", PATIENCE)
        for name in ("my-topic", "1st", "unreadable"):

            def is_refused(wanted: str = name) -> bool:
                texts = [line.msg for line in lines if line.name.startswith(self.space)]
                return any(wanted in text and "refused" in text for text in texts)

            wait_until(is_refused, lambda: f"{[line.msg for line in lines]}", PATIENCE)

    def test_motor_at_the_pins_of_the_node_follows_its_input(self) -> None:
        outputs = self.collect(f"{self.space}/motor_output", motor_output)
        publisher = rospy.Publisher(f"{self.space}/motor_input", motor_input, queue_size=1)
        words = [f"__ns:={self.space}", f"_link:={self.link}"]
        board = Process(str(PACKAGE / "scripts" / "avr_board.py"), words)
        self.addCleanup(board.end)
        self.start_node(115200)
        self.wait_for_connections(publisher)
        for share in (0.5, -0.5):

            def turns(wanted: float = 13.1 * share) -> bool:
                publisher.publish(motor_input(input=share))
                speeds = sorted(output.output for output in outputs[-50:])
                return len(speeds) == 50 and abs(speeds[25] - wanted) < 0.7

            wait_until(turns, lambda: f"{outputs[-1:]}", PATIENCE)
        board.interrupt()
        assert not os.path.islink(self.link)

    def test_sketch_of_the_tutorial_fits_into_an_uno(self) -> None:
        size = self.builder.size(self.builder.sketch(MOTOR_SKETCH, self.libraries))
        assert 4000 < size.flash < 32256 and 1000 < size.ram < 2048, size


if __name__ == "__main__":
    rospy.init_node("test_avr")
    rostest.rosrun("serial_link", "test_avr", TestAvr)
