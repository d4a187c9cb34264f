#!/usr/bin/env python3
"""Subscribe to numbered strings (see numbered()) and answer each line on stdin with a record."""

import json
import sys
import threading
import time

import rospy
from std_msgs.msg import String


def numbered(source: str, number: int, size: int) -> str:
    """Return a message that identifies itself and shows damage.

    :param source: who sends it, a letter
    :param number: its number
    :param size: its length, characters, at least 10
    :returns: the text
    """
    return (f"{source}{number:08d} " * (size // 10 + 1))[:size]


class Recorder:
    """Received messages."""

    def __init__(self) -> None:
        self.numbers = {}
        self.torn = 0
        self.longest_gap = 0.0
        self._last_time = None
        self._lock = threading.Lock()

    def on_message(self, message: String) -> None:
        """Record a message.

        :param message: the message
        """
        now = time.monotonic()
        text = message.data
        source, number = text[0], int(text[1:9])
        whole = text == numbered(source, number, len(text))
        with self._lock:
            if self._last_time is not None:
                self.longest_gap = max(self.longest_gap, now - self._last_time)
            self._last_time = now
            self.torn += not whole
            self.numbers.setdefault(source, []).append(number)

    def answer(self) -> None:
        """Print a record for each line of the standard input until it ends."""
        for _ in sys.stdin:
            with self._lock:
                gap = self.longest_gap
                record = {"numbers": self.numbers, "torn": self.torn, "longest_gap": gap}
                print(json.dumps(record), flush=True)
        rospy.signal_shutdown("input ended")


def main() -> None:
    """Run until the standard input ends."""
    rospy.init_node("recording_subscriber", anonymous=True)
    recorder = Recorder()
    rospy.Subscriber("topic", String, recorder.on_message)
    threading.Thread(target=recorder.answer, daemon=True).start()
    rospy.spin()


if __name__ == "__main__":
    main()
