"""One end of a hop within a ROS or through the bridge, written as users do.

Usage: hop.py send|hear 1|2 RATE SECONDS TOPICS FILE. Each message holds the moment when it was
sent; whoever hears writes into FILE, as JSON, how long each took, us, how many were lost, and how
many of these ROS 2 has told of: they were dropped where they were sent, as they were not taken.
Before that it makes an empty FILE.any when anything has come, FILE.first when a counted one has.
"""

import contextlib
import json
import pathlib
import signal
import sys
import threading
import time
from typing import Any, Callable, List

RATE, SECONDS, TOPICS = float(sys.argv[3]), float(sys.argv[4]), int(sys.argv[5])
NAMES = [f"/hop{number}" for number in range(TOPICS)]
#: how long whoever sends waits for the others, and whoever hears waits for the rest, s
PATIENCE, REST = 20.0, 1.0


class Heard:
    """What has come: the moments of sending are in the messages."""

    def __init__(self) -> None:
        self.took: List[float] = []
        self.dropped = 0
        self.latest = time.monotonic()

    def add_sample(self, message: Any) -> None:
        now = time.monotonic()
        if message.signal_y < 0.0:  # only to get going
            self.latest = now
            pathlib.Path(sys.argv[6] + ".any").touch()
            return
        if not self.took:
            pathlib.Path(sys.argv[6] + ".first").touch()
        self.took.append(1e6 * (now - message.time_x))
        self.latest = now

    def keep_dropped(self, event: Any) -> None:
        self.dropped = event.total_count

    def write(self) -> None:
        sent = int(RATE * SECONDS) * TOPICS
        file = pathlib.Path(sys.argv[6])
        unfinished = file.with_suffix(".new")
        lost = sent - len(self.took)
        text = json.dumps({"took": self.took, "lost": lost, "dropped": self.dropped})
        unfinished.write_text(text, "utf-8")
        unfinished.replace(file)  # where it is looked for, it is whole: a million take a while


def send(publish: List[Callable[[Any], Any]], counts: List[Callable[[], int]], cls: Any) -> None:
    """Send at the rate, once somebody hears each topic."""
    deadline = time.monotonic() + PATIENCE
    while min(count() for count in counts) < 1 and time.monotonic() < deadline:
        time.sleep(0.01)
    for _ in range(20):  # connections settle
        for one in publish:
            one(cls(signal_y=-1.0))
        time.sleep(0.05)
    start = time.monotonic()
    for number in range(int(RATE * SECONDS)):
        left = start + number / RATE - time.monotonic()
        if left > 0.0:
            time.sleep(left)
        for one in publish:
            one(cls(time_x=time.monotonic(), signal_y=float(number)))
    time.sleep(REST)


def end(*_: Any) -> None:
    """End at Ctrl-C; another one, while that is under way, would only break it off."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.exit(0)


def main(at_end: contextlib.ExitStack) -> None:
    """Send or hear, in one ROS.

    :param at_end: closes what is open
    """
    heard = Heard()
    if sys.argv[2] == "1":
        import rospy

        from basic_comms.msg import signal_msg as cls

        rospy.init_node("hop_" + sys.argv[1], disable_signals=True)
        if sys.argv[1] == "send":
            outs = [rospy.Publisher(name, cls, queue_size=None, tcp_nodelay=True) for name in NAMES]
            send([out.publish for out in outs], [out.get_num_connections for out in outs], cls)
            return
        for name in NAMES:
            rospy.Subscriber(name, cls, heard.add_sample, tcp_nodelay=True)
    else:
        import rclpy
        from rclpy.event_handler import SubscriptionEventCallbacks
        from rclpy.executors import ExternalShutdownException
        from rclpy.signals import SignalHandlerOptions
        from spinning import spin

        from basic_comms.msg import SignalMsg as cls2

        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        node = rclpy.create_node("hop_" + sys.argv[1])
        if sys.argv[1] == "send":
            at_end.callback(rclpy.shutdown)
            made = [node.create_publisher(cls2, name, 1000) for name in NAMES]
            send([one.publish for one in made], [one.get_subscription_count for one in made], cls2)
            return
        # All may wait here until it is their turn: what is lost then is lost on the way.
        depth = int(RATE * SECONDS) + 1000
        events = SubscriptionEventCallbacks(message_lost=heard.keep_dropped)
        for name in NAMES:
            node.create_subscription(cls2, name, heard.add_sample, depth, event_callbacks=events)

        def spin_node() -> None:
            with contextlib.suppress(ExternalShutdownException):
                spin(node)

        spinning = threading.Thread(target=spin_node, daemon=True)
        at_end.callback(spinning.join, 2.0)
        at_end.callback(rclpy.shutdown)
        spinning.start()
    expected = int(RATE * SECONDS) * TOPICS
    began = time.monotonic()
    while len(heard.took) < expected:
        time.sleep(0.1)
        patience = PATIENCE / 2.0 if heard.took else PATIENCE + SECONDS
        if time.monotonic() - max(heard.latest, began) > patience:
            break
    heard.write()


if __name__ == "__main__":
    signal.signal(signal.SIGINT, end)
    with contextlib.ExitStack() as stack:
        main(stack)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # it ends already
