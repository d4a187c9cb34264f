"""Base class of tests with sketches on a simulated AVR behind the node."""

import pathlib
import shutil
import tempfile
import unittest
from typing import Any, Dict, List, Sequence

import rospkg
import rospy
from diagnostic_msgs.msg import DiagnosticArray

from nodekit.testing.processes import Process
from nodekit.testing.waiting import wait_until
from serial_link.board.avr_board import AvrBoard, AvrBuilder
from serial_link.commands.make_headers import build_headers, write
from serial_link.headers.arduino_library import arduino_library

PACKAGE = pathlib.Path(rospkg.RosPack().get_path("serial_link"))
NODE = str(PACKAGE / "scripts" / "serial_node.py")
#: Longest wait for a board [s]: on a busy machine the simulator falls behind.
PATIENCE = 60.0


class AvrRig(unittest.TestCase):
    """Each test has its own boards and nodes; the compiled library and simulator are shared."""

    folder: pathlib.Path
    libraries: Sequence[pathlib.Path]
    simulator: pathlib.Path
    builder: AvrBuilder

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        headers = build_headers(["std_msgs", "std_srvs", "pid_control"])
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
        #: The nodes, by namespace.
        self.nodes: Dict[str, Process] = {}

    def start_node(self, baud: int) -> None:
        node = Process(NODE, [f"__ns:={self.space}", f"_port:={self.link}", f"_baud:={baud}"])
        self.addCleanup(node.end)
        self.nodes[self.space] = node

    def start(self, text: str, baud: int = 57600) -> AvrBoard:
        """Run a sketch, and the node, until the end of the test."""
        sketch = self.folder / (self.name + ".ino")
        sketch.write_text(text)
        program = self.builder.sketch(sketch, self.libraries)
        board = AvrBoard(self.simulator, program, self.link)
        board.start()
        self.addCleanup(board.close)
        self.start_node(baud)
        return board

    def collect(self, topic: str, data_class: Any) -> List[Any]:
        """Return a list that receives a topic's messages."""
        messages: List[Any] = []
        subscriber = rospy.Subscriber(topic, data_class, messages.append)
        self.addCleanup(subscriber.unregister)
        return messages

    def wait_for_connections(self, publisher: rospy.Publisher) -> None:
        wait_until(lambda: publisher.get_num_connections() > 0, lambda: "no node", PATIENCE)

    def collect_counters(self) -> Dict[str, int]:
        """Return a dictionary that follows the counters of the test's node."""
        counters: Dict[str, int] = {}

        def update(message: DiagnosticArray) -> None:
            if message.status[0].name.startswith(self.space[1:] + "/"):
                counters.update((one.key, int(one.value)) for one in message.status[0].values)

        subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, update)
        self.addCleanup(subscriber.unregister)
        return counters
