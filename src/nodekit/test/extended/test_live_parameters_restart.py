#!/usr/bin/env python3
"""Tests of live parameters after a restart of the master."""

import contextlib
import http.server
import signal
import threading
import urllib.parse
from typing import Any, Iterator, Optional

from helpers.parameter_node import GaugeParameters
from helpers.parameter_rig import ParameterCase, ParameterNode

from nodekit.parameters.declaration import to_wire
from nodekit.testing.processes import Master, Server, hanging
from nodekit.testing.running import rosrun
from nodekit.testing.slow_master import SlowMaster
from nodekit.testing.waiting import wait_until

DEFAULTS = {name: to_wire(value) for name, value in GaugeParameters().as_dict().items()}


class RestartedMaster(ParameterCase):
    """A master of the test's own."""

    def setUp(self) -> None:
        self.master = Master()
        self.addCleanup(lambda: self.master.kill())
        self.server = Server(self.master.uri)

    def start(self) -> ParameterNode:
        return self.start_node("/gauge", ROS_MASTER_URI=self.master.uri)

    def restart(self, node: ParameterNode) -> None:
        """Kill the master, wait until the node notices, and start another."""
        self.master.kill()
        node.wait_for_log("WARN", "the master does not answer")
        self.master.start()
        self.server = Server(self.master.uri)

    def test_values_in_force_are_kept_and_written(self) -> None:
        node = self.start()
        self.server.set("/gauge", {**DEFAULTS, "level": 5, "title": "kept", "marks": []})
        node.wait_for(level=5.0, title="kept", marks=[])
        changes = node.changes
        self.restart(node)
        self.assert_truth(node, self.server)
        self.assertEqual(node.values, {**DEFAULTS, "level": 5.0, "title": "kept", "marks": []})
        self.assertEqual(node.changes, changes)
        node.wait_for_log("INFO", "the master answers again")
        node.wait_for_log("WARN", "the master was restarted")
        self.assertEqual(len(node.logged("the master was restarted")), 1)
        self.assertEqual(len(node.logged("the master does not answer")), 1)
        wait_until(lambda: "/gauge/describe" in self.server.services(), self.server.services)

        self.server.set("/gauge/level", 6)
        node.wait_for(level=6.0)
        self.server.delete("/gauge/title")
        node.wait_for(title="gauge")
        self.assertEqual(node.interrupt(), 0)
        wait_until(lambda: not self.server.knows("/gauge"), lambda: "it is still registered")

    def test_values_already_set_on_the_new_master_take_precedence(self) -> None:
        node = self.start()
        self.server.set("/gauge", {**DEFAULTS, "level": 5, "title": "kept"})
        node.wait_for(level=5.0, title="kept")
        with hanging(node.popen.pid):
            self.master.kill()
            self.master.start()
            self.server = Server(self.master.uri)
            self.server.set("/gauge", {"level": 6, "count": -1})
        self.assert_truth(node, self.server)
        self.assertEqual(node.values, {**DEFAULTS, "level": 6.0, "title": "kept"})
        node.wait_for_log("WARN", "/gauge/count: refused -1")
        self.assertEqual(len(node.logged("WARN", "/gauge/count: refused -1")), 1)

    def test_master_that_refuses_every_registration_was_not_restarted(self) -> None:
        refusing = RefusingMaster(self.master.uri)
        self.addCleanup(refusing.close)
        node = self.launch_node("/gauge", ROS_MASTER_URI=refusing.uri)
        refused = "the master rejected the registration of /gauge/describe"
        node.wait_for_log("ERROR", refused)
        asked = refusing.calls.count("getPid")
        wait_until(  # at the start, twice in the first second, and once in the next two
            lambda: refusing.calls.count("getPid") >= asked + 5,
            lambda: "the master is asked no more",
        )
        self.assertLessEqual(len(node.logged(refused)), 2)
        self.assertEqual(node.logged("the master was restarted"), [])
        self.assertEqual(node.logged("the master had forgotten"), [])

    def test_page_in_place_of_an_answer_is_a_master_that_does_not_answer(self) -> None:
        node = self.start()
        self.server.set("/gauge/level", 5)
        node.wait_for(level=5.0)
        with contextlib.ExitStack() as page:
            with hanging(node.popen.pid):  # otherwise it first finds no master, and logs only that
                self.master.kill()
                page.enter_context(login_page(urllib.parse.urlsplit(self.master.uri).port))
            node.wait_for_log("WARN", "the master does not answer", "not XML-RPC")
        self.master.start()
        self.server = Server(self.master.uri)
        self.assert_truth(node, self.server)
        self.server.set("/gauge/level", 6)
        node.wait_for(level=6.0)

    def test_master_that_hangs_while_topics_are_registered_again(self) -> None:
        slow = SlowMaster(self.master.uri, "registerService", "/describe")
        self.addCleanup(slow.close)
        slow.go_on.set()
        node = self.start_node("/gauge", ROS_MASTER_URI=slow.uri)
        self.server.set("/gauge/level", 5)
        node.wait_for(level=5.0)
        slow.reached.clear()
        slow.go_on.clear()
        self.master.kill()
        self.master.start()
        self.server = Server(self.master.uri)
        wait_until(slow.reached.is_set, lambda: "nothing is registered again")
        # Only now: earlier lines may have been delayed.
        answers = len(node.logged("the master answers again"))
        asked = slow.asked
        self.master.send_signal(signal.SIGSTOP)
        slow.go_on.set()
        wait_until(
            lambda: slow.asked > asked, lambda: f"the thread waits for ever: {node.logged()}"
        )
        # Earlier log lines may arrive a moment later, over a pipe.
        node.wait_for_log("WARN", "the master does not answer")
        self.assertEqual(len(node.logged("WARN", "the master does not answer")), 1)
        self.master.send_signal(signal.SIGCONT)
        wait_until(
            lambda: len(node.logged("the master answers again")) > answers,
            lambda: str(node.logged()),
        )
        self.assert_truth(node, self.server)
        self.assertEqual(node.values["level"], 5.0)
        self.server.set("/gauge/level", 6)
        node.wait_for(level=6.0)


class RefusingMaster(SlowMaster):
    """Refuses to register anything."""

    def __init__(self, master_uri: str) -> None:
        super().__init__(master_uri, "", "")

    def _dispatch(self, method: str, arguments: Any) -> Any:
        if method.startswith(("register", "subscribe")):
            self.calls.append(method)
            return [-1, "refused", 0]
        return super()._dispatch(method, arguments)


@contextlib.contextmanager
def login_page(port: Optional[int]) -> Iterator[None]:
    """Answer each request with a page, as the gateway of a hotel does."""

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            self.rfile.read(int(self.headers["Content-Length"]))
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"<!DOCTYPE html><html><body>Please log in<br></body></html>")

        def log_message(self, *_: Any) -> None:
            pass

    server = http.server.HTTPServer(("localhost", port or 0), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.01,))
    thread.start()
    try:
        yield
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


if __name__ == "__main__":
    rosrun("nodekit", "live_parameters_restart", RestartedMaster)
