"""One end of a hop within a ROS or through the bridge, written as users would.

Usage: hop.py send|receive 1|2 RATE SECONDS TOPICS FILE. Each message holds the moment of its
sending. The receiver writes to FILE, as JSON, how long each took [us], and how many were lost. At
the first message it makes FILE.first.
"""

import contextlib
import json
import pathlib
import signal
import sys
import threading
import time
from typing import Any, Callable, List

ROLE, ROS, RATE, SECONDS, TOPICS = sys.argv[1], sys.argv[2], *map(float, sys.argv[3:6])
FILE = pathlib.Path(sys.argv[6])
NAMES = [f"/hop{number}" for number in range(int(TOPICS))]
EXPECTED = int(RATE * SECONDS) * len(NAMES)
#: Longest wait for the other end, and time for the last messages to arrive [s].
PATIENCE, REST = 20.0, 1.0


class Received:
    """Messages that have arrived so far."""

    def __init__(self) -> None:
        self.took: List[float] = []
        self.latest = time.monotonic()

    def add_sample(self, message: Any) -> None:
        now = self.latest = time.monotonic()
        if message.signal_y < 0.0:  # only to establish the connection
            return
        if not self.took:
            FILE.with_suffix(".first").touch()
        self.took.append(1e6 * (now - message.time_x))

    def wait(self) -> None:
        """Wait for all messages, or until no more arrive."""
        self.latest = max(self.latest, time.monotonic())
        while len(self.took) < EXPECTED:
            time.sleep(0.1)
            patience = PATIENCE / 2.0 if self.took else PATIENCE + SECONDS
            if time.monotonic() - self.latest > patience:
                return

    def write(self) -> None:
        unfinished = FILE.with_suffix(".new")
        lost = EXPECTED - len(self.took)
        text = json.dumps({"took": self.took, "lost": lost})
        unfinished.write_text(text, "utf-8")
        unfinished.replace(FILE)  # complete when it appears: writing a million takes a while


def send(publish: List[Callable[[Any], Any]], counts: List[Callable[[], int]], cls: Any) -> None:
    """Send at the rate, once each topic has a subscriber."""
    deadline = time.monotonic() + PATIENCE
    while min(count() for count in counts) < 1 and time.monotonic() < deadline:
        time.sleep(0.01)
    for _ in range(20):  # connections settle
        for one in publish:
            one(cls(signal_y=-1.0))
        time.sleep(0.05)
    start = time.monotonic()
    for number in range(int(RATE * SECONDS)):
        time.sleep(max(0.0, start + number / RATE - time.monotonic()))
        for one in publish:
            one(cls(time_x=time.monotonic(), signal_y=float(number)))
    time.sleep(REST)


def run_in_ros1() -> None:
    """Send or receive with rospy."""
    import rospy

    from basic_comms.msg import signal_msg

    rospy.init_node("hop_" + ROLE, disable_signals=True)
    if ROLE == "send":
        outs = [
            rospy.Publisher(name, signal_msg, queue_size=None, tcp_nodelay=True) for name in NAMES
        ]
        send([one.publish for one in outs], [one.get_num_connections for one in outs], signal_msg)
        return
    received = Received()
    for name in NAMES:
        rospy.Subscriber(name, signal_msg, received.add_sample, tcp_nodelay=True)
    received.wait()
    received.write()


def run_in_ros2(at_end: contextlib.ExitStack) -> None:
    """Send or receive with rclpy.

    :param at_end: closes what is open
    """
    import rclpy
    from rclpy.executors import ExternalShutdownException
    from rclpy.signals import SignalHandlerOptions

    from basic_comms.msg import SignalMsg

    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("hop_" + ROLE)
    if ROLE == "send":
        at_end.callback(rclpy.shutdown)
        outs = [node.create_publisher(SignalMsg, name, 1000) for name in NAMES]
        send([one.publish for one in outs], [one.get_subscription_count for one in outs], SignalMsg)
        return
    received = Received()
    # Depth for all messages: any loss is then in transport.
    depth = int(RATE * SECONDS) + 1000
    for name in NAMES:
        node.create_subscription(SignalMsg, name, received.add_sample, depth)

    def spin() -> None:
        with contextlib.suppress(ExternalShutdownException):
            rclpy.spin(node)

    spinning = threading.Thread(target=spin, daemon=True)
    at_end.callback(spinning.join, 2.0)
    at_end.callback(rclpy.shutdown)
    spinning.start()
    received.wait()
    received.write()


def end(*_: Any) -> None:
    """End at Ctrl-C; a second one would only interrupt that."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.exit(0)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, end)
    with contextlib.ExitStack() as stack:
        if ROS == "1":
            run_in_ros1()
        else:
            run_in_ros2(stack)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is ending already
