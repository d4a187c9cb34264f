"""A board of the test's own, with any sketch, and the node."""

import os
import queue
import shutil
import tempfile
import unittest
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

import rospkg
import rospy
from std_msgs.msg import String
from std_srvs.srv import SetBool

from nodekit.testing.processes import Process
from nodekit.testing.waiting import wait_until
from serial_link.board.transports import PtyTransport
from serial_link.board.simulation import SimulatedBoard
from serial_link.device.rosserial_device import Device, Endpoint
from serial_link.endpoints.types import encode
from serial_link.negotiation.payloads import (
    PUBLISHER,
    SERVICE_CLIENT,
    SERVICE_SERVER,
    SUBSCRIBER,
    ParameterValues,
)

SCRIPTS = os.path.join(rospkg.RosPack().get_path("serial_link"), "scripts")
BUFFER = 100
REQUEST, RESPONSE = SetBool._request_class, SetBool._response_class


def endpoint(kind: int, name: str, data_class: Any) -> Endpoint:
    if kind in (SERVICE_SERVER, SERVICE_CLIENT):
        sums = data_class._request_class._md5sum, data_class._response_class._md5sum
        return Endpoint(kind, name, data_class._type, *sums)
    return Endpoint(kind, name, data_class._type, data_class._md5sum)


class TestSketch:
    """Sketch that records its messages, and executes the test's queue."""

    topics: Sequence[Endpoint] = (
        endpoint(PUBLISHER, "said", String),
        endpoint(SUBSCRIBER, "told", String),
        endpoint(SERVICE_SERVER, "offered", SetBool),
        endpoint(SERVICE_CLIENT, "called", SetBool),
        Endpoint(PUBLISHER, "strange", "no_such_msgs/Thing", "0" * 32),
        Endpoint(SUBSCRIBER, "stranger", "std_msgs/NoSuchThing", "0" * 32),
    )

    def __init__(self) -> None:
        self.heard: List[Tuple[str, bytes]] = []
        self.parameters: List[ParameterValues] = []
        self.todo: "queue.Queue[Callable[[Device], None]]" = queue.Queue()
        self.answers = True

    def on_message(self, device: Device, now: float, name: str, payload: bytes) -> None:
        self.heard.append((name, payload))
        if name == "offered" and self.answers:
            wanted = REQUEST().deserialize(payload).data
            device.publish(name, encode(RESPONSE(wanted, "from the board")))

    def on_parameter(self, device: Device, now: float, values: ParameterValues) -> None:
        self.parameters.append(values)

    def loop(self, device: Device, now: float) -> None:
        if device.is_configured and not self.todo.empty():
            self.todo.get()(device)

    def next_due(self, now: float) -> float:
        return now + 0.01

    def texts(self) -> List[str]:
        """Return the received messages."""
        return [String().deserialize(data).data for name, data in self.heard if name == "told"]


class BoardRig(unittest.TestCase):
    """Each test has its own namespace, board and node."""

    def setUp(self) -> None:
        self.space = "/" + self.id().rsplit(".", 1)[-1]
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.port = os.path.join(self.folder, "board")
        self.sketch = TestSketch()
        self.end = PtyTransport(self.port)
        self.buffer = BUFFER
        make = lambda now: Device(self.sketch, self.buffer, 512)  # noqa: E731
        self.board = SimulatedBoard(self.end, 115200, make)

    def start(self, *words: str, environment: Optional[Dict[str, str]] = None) -> Process:
        """Switch the board on and start the node; both end with the test."""
        self.board.start()
        self.addCleanup(self.board.close)
        return self.start_node(*words, environment=environment)

    def start_node(self, *words: str, environment: Optional[Dict[str, str]] = None) -> Process:
        arguments = ["__ns:=" + self.space, f"_port:={self.port}", "_baud:=115200", *words]
        node = Process(os.path.join(SCRIPTS, "serial_node.py"), arguments, environment)
        self.addCleanup(node.end)
        return node

    def publisher(self, **options: Any) -> rospy.Publisher:
        publisher = rospy.Publisher(self.space + "/told", String, **{"queue_size": 2000, **options})
        self.addCleanup(publisher.unregister)
        return publisher

    def wait_until_told(self, *texts: str) -> None:
        wait_until(
            lambda: set(texts) <= set(self.sketch.texts()),
            lambda: f"{texts} not among {self.sketch.texts()[-5:]}",
        )

    def do(self, work: Callable[[Device], None]) -> None:
        self.sketch.todo.put(work)
