"""Start and end of the scope, also while the master restarts."""

import os
import shutil
import signal
import socket
import subprocess
import tempfile
import unittest
from typing import Any, Dict, List

import rosgraph
import roslib.packages
from wire.client import Client, fetch

from nodekit.testing.processes import Master, free_port
from nodekit.testing.waiting import wait_until


class Life(unittest.TestCase):
    """Tests that start scopes, on the test's master or on a separate one."""

    def setUp(self) -> None:
        self.master_uri = rosgraph.get_master_uri()
        self.port = free_port()
        self.url = f"http://localhost:{self.port}"

    def start(self, *command: str, **variables: str) -> "subprocess.Popen[str]":
        environment: Dict[str, str] = {
            **os.environ,
            "ROS_MASTER_URI": self.master_uri,
        }
        process = subprocess.Popen(
            list(command),
            env={**environment, **variables},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            universal_newlines=True,
        )
        self.addCleanup(self.end, process)
        return process

    def end(self, process: "subprocess.Popen[str]", number: int = signal.SIGINT) -> str:
        """End a process; return its output."""
        if process.poll() is None:
            process.send_signal(number)
        text = process.communicate(timeout=30.0)[0] if process.stdout else ""
        process.stdout = None
        return text

    def start_node(self, package: str, name: str, *arguments: str) -> "subprocess.Popen[str]":
        return self.start(roslib.packages.find_node(package, name)[0], *arguments)

    def start_scope(self, *arguments: str, **variables: str) -> "subprocess.Popen[str]":
        node = roslib.packages.find_node("topic_scope", "scope.py")[0]
        scope = self.start(node, "--port", str(self.port), *arguments, **variables)

        def is_served() -> bool:
            try:
                return fetch(self.url)[0] == 200
            except OSError:
                return False

        wait_until(is_served, lambda: f"no page at {self.url}")
        return scope

    def page(self, *fields: str) -> Client:
        client = Client(self.url)
        self.addCleanup(client.close)
        client.wait_for("hello")
        client.send("select", fields=list(fields))
        return client

    def test_scope_logs_its_address_listens_locally_and_ends_cleanly(self) -> None:
        """It starts no program, such as rospack, that Ctrl-C would end too."""
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        rospack = os.path.join(folder, "rospack")
        with open(rospack, "w") as file:
            file.write("#!/bin/sh\nkill -INT $$\n")
        os.chmod(rospack, 0o755)
        for number in (signal.SIGINT, signal.SIGTERM):
            scope = self.start_scope(PATH=folder + os.pathsep + os.environ["PATH"])
            self.assertEqual(self.listening(), ["127.0.0.1"])
            if number == signal.SIGINT:
                self.second_scope_says_that_the_port_is_taken()
            page = self.page("/a/x")
            page.wait_for("frame")
            text = self.end(scope, number)
            self.assertEqual(scope.returncode, 0, text)
            self.assertIn(self.url, text)
            self.assertNotIn("Traceback", text)
            wait_until(lambda: page.is_closed, lambda: "the page is still connected")

    def second_scope_says_that_the_port_is_taken(self) -> None:
        """Start another scope, which prints advice and exits."""
        second = self.start_node("topic_scope", "scope.py", f"_port:={self.port}")
        text = self.end_of(second)
        self.assertEqual(second.returncode, 1, text)
        self.assertIn(f"port {self.port} is taken", text)
        self.assertIn("--port", text)
        self.assertNotIn("Traceback", text)

    def test_next_free_port_is_used_on_request(self) -> None:
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", self.port))
            taken.listen()
            wanted, command = self.port, ["--next-port", "--port", str(self.port)]
            scope = self.start_node("topic_scope", "scope.py", *command, "__ns:=other")
            line = next(line for line in scope.stdout or () if "is taken" in line)
            self.port = int(line.split()[-1])
            self.assertIn(f"port {wanted} is taken: the next free one is", line)
            self.assertIn(self.port, range(wanted + 1, wanted + 100))
            self.url = f"http://localhost:{self.port}"
            self.assertEqual(fetch(self.url)[0], 200)
        self.end(scope)
        self.assertEqual(scope.returncode, 0)

    def test_address_of_another_machine_is_rejected(self) -> None:
        scope = self.start_node("topic_scope", "scope.py", "--address", "192.0.2.1")
        text = self.end_of(scope)
        self.assertEqual(scope.returncode, 1, text)
        self.assertIn("192.0.2.1", text)
        self.assertNotIn("Traceback", text)

    def end_of(self, process: "subprocess.Popen[str]") -> str:
        """Return the output of a process that exits by itself."""
        text: Any = process.communicate(timeout=30.0)[0]
        process.stdout = None
        return str(text)

    def listening(self) -> List[str]:
        """Return the addresses that the scope listens on."""
        found = []
        for name in ("/proc/net/tcp", "/proc/net/tcp6"):
            with open(name) as table:
                for line in table.read().splitlines()[1:]:
                    address, _, port = line.split()[1].rpartition(":")
                    if int(port, 16) == self.port and line.split()[3] == "0A":
                        data = bytes.fromhex(address)[::-1]
                        found.append(socket.inet_ntop(socket.AF_INET, data[-4:]))
        return found

    def test_survives_a_restart_of_the_master(self) -> None:
        master = Master()
        self.addCleanup(master.kill)
        self.master_uri = master.uri
        self.start_node("basic_comms", "signal_generator.py", "_rate:=50")
        self.start_scope("/signal/signal_y")
        page = self.page("/signal/signal_y", "/proc_signal/data")
        wait_until(lambda: page.values("/signal/signal_y"), lambda: page.bins)
        master.kill()
        page.wait_for("master", lambda reply: "does not answer" in reply["text"])
        page.forget()
        page.wait_for("frame", lambda frame: any(frame["traces"]["/signal/signal_y"]))
        self.page().wait_for("master", lambda reply: "does not answer" in reply["text"])
        master.start()
        page.wait_for("master", lambda reply: reply["text"] == "")
        # A node that starts only now is found, with its parameters.
        self.start_node("basic_comms", "process.py")
        wait_until(lambda: page.values("/proc_signal/data"), lambda: page.bins)
        page.wait_for("panels", lambda reply: "/process" in str(reply["panels"]))
        page.forget()
        page.wait_for("frame", lambda frame: any(frame["traces"]["/signal/signal_y"]))
        page.send("set", node="/process", name="offset", value=5.0)
        wait_until(
            lambda: max(page.values("/proc_signal/data")) > 5.0,
            lambda: (page.messages("refused"), page.messages("error")),
        )
