#!/usr/bin/env python3
"""Subscribe to numbered arrays (see numbered()) and answer each line on stdin with a record.

The first argument says how: ``nodekit``, ``views`` or ``rospy``; or ``relay``, which publishes what
it views again, on ``topic/again``.
"""

import json
import os
import sys
import threading
import time

import rospy
from std_msgs.msg import UInt8MultiArray

from nodekit import run

#: Length of the number at an array's start [bytes].
NUMBER = 8


def numbered(number: int, size: int) -> bytes:
    """Return an array that identifies itself and shows damage.

    :param number: its number
    :param size: its length [bytes], at least :data:`NUMBER`
    """
    return number.to_bytes(NUMBER, "big") + bytes([number % 251]) * (size - NUMBER)


class Recorder:
    """Received messages."""

    def __init__(self) -> None:
        self._numbers = []
        self._torn = 0
        self._types = set()
        self._kept = []
        self.again = None
        #: number of messages to keep the arrays of
        self.to_keep = 0

    def on_message(self, message: UInt8MultiArray) -> None:
        """Record a message.

        :param message: the message
        """
        array = message.data
        self._types.add(type(array).__name__)
        number = int.from_bytes(array[:NUMBER], "big")
        self._torn += array != numbered(number, len(array))
        if len(self._kept) < self.to_keep:
            self._kept.append((number, array))
        if self.again is not None:
            self.again(message)
        self._numbers.append(number)

    def publish_kept(self, publish) -> None:
        """Publish the kept arrays.

        :param publish: publishes a message
        """
        for _, array in self._kept:
            publish(UInt8MultiArray(data=array))

    def record(self) -> str:
        """Return all that is recorded, as JSON."""
        kept = [array == numbered(number, len(array)) for number, array in self._kept]
        record = {
            "numbers": list(self._numbers),
            "torn": self._torn,
            "types": sorted(self._types),
            "kept": kept,
        }
        return json.dumps(record)


recorder = Recorder()


def refusal() -> str:
    """Return the error of a plain publisher that gets the kept arrays."""
    plain = rospy.Publisher(rospy.resolve_name("topic") + "/plain", UInt8MultiArray, queue_size=1)
    while not plain.get_num_connections():
        time.sleep(0.01)
    try:
        recorder.publish_kept(plain.publish)
    except rospy.ROSException as error:
        return str(error)
    return ""


def answer() -> None:
    """Execute the lines of standard input: print a record, fork, keep, drop or publish arrays."""
    for line in sys.stdin:
        word, _, number = line.strip().partition(" ")
        if word == "keep":
            recorder.to_keep = int(number)
            recorder._kept.clear()
        elif word == "fork":
            if os.fork() == 0:
                time.sleep(float(number))
                os._exit(0)
        elif word == "publish":
            recorder.publish_kept(recorder.again)
        print(json.dumps(refusal()) if word == "refusal" else recorder.record(), flush=True)
    os._exit(0)


class ArraySubscriber:
    """Node with one subscription."""

    def __init__(self, node) -> None:
        is_viewing = sys.argv[1] in ("views", "relay")
        if sys.argv[1] == "relay":
            name = rospy.resolve_name("topic") + "/again"
            recorder.again = node.create_publisher(name, UInt8MultiArray, queue_size=10).publish
        node.create_subscription("topic", UInt8MultiArray, recorder.on_message, views=is_viewing)


def main() -> None:
    """Run until the standard input ends."""
    threading.Thread(target=answer, daemon=True).start()
    if sys.argv[1] == "rospy":
        rospy.init_node("array_subscriber", anonymous=True)
        rospy.Subscriber("topic", UInt8MultiArray, recorder.on_message)
        rospy.spin()
    else:
        run(f"array_subscriber_{os.getpid()}", ArraySubscriber)


if __name__ == "__main__":
    main()
