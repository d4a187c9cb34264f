"""Record a topic, from the host that this runs on, until Ctrl-C: observe.py TOPIC TYPE FILE.

Each sample is kept with the moment it came: its time_x, or the answer.
"""

import os
import signal
import socket
import struct
import sys
import threading

from ..benchmark import record
from ..benchmark.tcpros import Node, split_messages

#: where the number to keep stands, by type of message
NUMBERS = {"basic_comms/signal_msg": "<8xd", "std_msgs/Float32": "<f"}


def main(topic: str, type_name: str, file: str) -> None:
    """Record until interrupted."""
    kept = record.Record(file + ".new")
    layout = struct.Struct(NUMBERS[type_name])
    done = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: done.set())

    def read(connection: socket.socket) -> None:
        rest = b""
        while True:
            data = connection.recv(65536)
            if not data:
                return
            messages, rest = split_messages(rest + data)
            for message in messages:
                kept.add(layout.unpack_from(message)[0])

    node = Node(f"/observe_{os.getpid()}", os.environ["ROS_MASTER_URI"])
    node.subscribe(
        topic,
        type_name,
        lambda connection: threading.Thread(target=read, args=(connection,), daemon=True).start(),
    )
    while not done.wait(0.1):
        pass
    os.rename(file + ".new", file)


if __name__ == "__main__":
    main(*sys.argv[1:])
