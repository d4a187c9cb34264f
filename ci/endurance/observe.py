"""Record a topic, from the host that this runs on, until Ctrl-C: observe.py TOPIC TYPE FILE.

Each sample is kept with the moment of its arrival: its time_x, or the answer.
"""

import os
import signal
import socket
import struct
import sys
import threading

from ..benchmark.record import Record
from ..benchmark.tcpros import Node, receive_messages

#: Place of the number to keep, by type of message.
NUMBERS = {"basic_comms/signal_msg": "<8xd", "std_msgs/Float32": "<f"}


def main(topic: str, type_name: str, file: str) -> None:
    """Record until interrupted."""
    kept = Record(file + ".new")
    layout = struct.Struct(NUMBERS[type_name])
    done = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: done.set())

    def read(connection: socket.socket) -> None:
        for _, messages in receive_messages(connection):
            for message in messages:
                kept.add(layout.unpack_from(message)[0])

    node = Node(f"/observe_{os.getpid()}", os.environ["ROS_MASTER_URI"])
    node.subscribe(topic, type_name, read)
    while not done.wait(0.1):
        pass
    os.rename(file + ".new", file)


if __name__ == "__main__":
    main(*sys.argv[1:])
