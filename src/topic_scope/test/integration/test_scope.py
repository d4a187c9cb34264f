#!/usr/bin/env python3
"""Messages and requests of pages: signals, panels, the graph, robots, and access."""

import http.client
import json
import math
import time
from typing import Any, Callable, Dict, Tuple

import rosnode
import rospy
from geometry_msgs.msg import Twist, TwistStamped
from sensor_msgs.msg import Image
from std_msgs.msg import Float32, Float64, Header
from tornado.httpclient import HTTPClientError
from wire.client import Client, fetch, fetch_image
from wire.controls_test import NODE, ControlsTest
from wire.robot import Robot
from wire.robots_test import RobotsTest
from wire.scope_test import ScopeTest
from wire.signals_test import PEAK, SignalsTest

from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

#: Limit documented in docs/nodes/scope.md [s].
STOPS_WITHIN_S = 0.3
#: Number of tries on a busy machine.
ATTEMPTS = 8


class Signals(SignalsTest):
    """Every sample is sent, including earlier samples for later pages."""

    def test_page_gets_hello_and_available_fields(self) -> None:
        page = self.page()
        hello = page.wait_for("hello")
        self.assertEqual(hello["fields"], ["/signal/signal_y", "/proc_signal/data"])
        self.assertFalse(hello["readonly"])
        reply = page.wait_for("fields", lambda reply: "/signal/time_x" in str(reply))
        fields = {(one["field"], one["datatype"], one["topic"]) for one in reply["fields"]}
        updates = "/signal_generator/parameter_updates"
        self.assertIn(("/signal/time_x", "float64", "/signal"), fields)
        self.assertIn((updates + "/doubles[0]/value", "float64", updates), fields)
        self.assertEqual(reply["types"]["/signal"], "basic_comms/signal_msg")
        self.assertEqual(reply["types"][updates], "dynamic_reconfigure/Config")
        page.wait_for("alive")

    def test_every_sample_is_in_a_frame_and_in_the_csv(self) -> None:
        field = "/every/data"
        page = self.page(field)
        publisher = self.publisher("/every", Float32, page)
        sent = [math.sin(index / 50.0) for index in range(500)]
        sent[333] = PEAK
        self.publish(publisher, sent)
        wait_until(lambda: len(self.samples(field)) == len(sent), lambda: len(self.samples(field)))
        rows = self.samples(field)
        for (_, (text,)), value in zip(rows, sent):
            self.assertAlmostEqual(float(text), value, delta=abs(value) * 1e-7)
        wait_until(lambda: float(rows[-1][1][0]) in page.values(field), lambda: page.bins)
        # The bins of the screen match the samples.
        shown, bins = page.bins_of(field), {}
        for moment, (text,) in rows:
            bins.setdefault(math.floor(moment / page.width), []).append(float(text))
        for index, values in bins.items():
            self.assertEqual(shown[index], [min(values), max(values)])
        # On a busy machine the peak may be alone in its bin, as both minimum and maximum.
        self.assertEqual(sum(PEAK in pair for pair in shown.values()), 1)

    def test_a_late_page_gets_the_history(self) -> None:
        first = self.page("/late/data")
        publisher = self.publisher("/late", Float64, first)
        self.publish(publisher, [1.0, PEAK, -PEAK, 2.0])
        wait_until(lambda: PEAK in first.values("/late/data"), lambda: first.bins)
        second = self.page("/late/data")
        frame = second.wait_for("frame", lambda frame: bool(frame["traces"].get("/late/data")))
        self.assertTrue(frame["reset"])
        seen = [value for value in frame["traces"]["/late/data"] if value is not None]
        self.assertEqual((max(seen), min(seen)), (PEAK, -PEAK))

    def test_images_are_received_only_while_a_page_shows_them(self) -> None:
        page, url = self.page(), self.scope.url
        page.send("images", topic="/camera/image")
        publisher = self.publisher("/camera/image", Image, page)
        for grey in (10, 20):
            stamp = rospy.Time.now()
            publisher.publish(Image(Header(0, stamp, ""), 1, 2, "mono8", 0, 2, bytes([grey] * 2)))
            wait_until(
                lambda: (
                    abs(fetch_image(url, "/camera/image")[0].get("time", 0) - stamp.to_sec()) < 1e-6
                ),
                lambda: fetch_image(url, "/camera/image"),
            )
        found, kind, file = fetch_image(url, "/camera/image")
        self.assertEqual((found["text"], kind), ("2 × 1, mono8", "image/png"))
        earlier, _, other = fetch_image(url, "/camera/image", time=str(found["time"] - 1e-4))
        self.assertLess(earlier["time"], found["time"])
        self.assertNotEqual(other, file)
        # A page that closes needs it no longer.
        page.close()
        wait_until(
            lambda: not publisher.get_num_connections(), lambda: "the scope is still subscribed"
        )

    def test_measures_and_triggers(self) -> None:
        page = self.page("/signal/signal_y")
        page.send("view", window=2.0, width=500, end=None)
        found = page.wait_for(
            "stats",
            # By the stamps of the messages it is exact, however late they arrive.
            lambda stats: abs((stats["traces"]["/signal/signal_y"]["frequency"] or 0) - 1.0) < 1e-4,
        )["traces"]["/signal/signal_y"]
        self.assertAlmostEqual(found["rate"], 100.0, delta=10.0)
        self.assertAlmostEqual(found["max"], 2.0, delta=0.01)
        self.assertLess(abs(found["frequency"] - 1.0), found["uncertainty"]["frequency"])
        page.send("view", window=1.0, width=500, end=None)
        page.wait_for(
            "stats",
            lambda stats: (
                stats["traces"]["/signal/signal_y"]["unmeasurable"]
                == {"frequency": "fewer than two periods in the span"}
            ),
        )
        page.send("view", window=2.0, width=500, end=None)
        edge = {"field": "/signal/signal_y", "level": 0.5, "edge": "falling"}
        page.send("trigger", mode="single", number=5, **edge)
        # The state armed is sent only if the first search finds no crossing.
        reply = page.wait_for("trigger", lambda message: message["state"] == "triggered")
        self.assertEqual(reply["number"], 5)
        crossing = reply["time"]
        rows = [(moment, float(row[0])) for moment, row in self.samples("/signal/signal_y")]
        # Samples that arrive together are so close that it may be rounded to the second.
        (before, high), (after, low) = next(
            (one, other)
            for one, other in zip(rows, rows[1:])
            if one[0] <= crossing <= other[0] and one[1] > 0.5 >= other[1]
        )
        expected = before + (high - 0.5) / (high - low) * (after - before)
        self.assertAlmostEqual(crossing, expected, delta=1e-6)
        # Held: the span around it is sent once, and then no further frames.
        page.send("view", window=1.0, width=125, end=crossing - 1.0)
        held = page.wait_for("frame", lambda frame: frame["reset"] and frame["bin"] == 0.008)
        first = math.floor((crossing - 2.0) / 0.008)
        self.assertAlmostEqual(held["first"], first, delta=1)
        count = len(page.messages("stats"))
        wait_until(lambda: len(page.messages("stats")) > count + 2, lambda: "no more stats")
        self.assertEqual(page.messages("frame")[-1], held)


class Controls(ControlsTest):
    """Panels of nodes, values that are set and rejected, and the graph."""

    def test_panel_shows_the_description_of_the_node(self) -> None:
        self.panelled()
        shown = {entry["name"]: entry for entry in self.panels[NODE]["parameters"]}
        self.assertEqual(
            {key: shown["rate"][key] for key in ("kind", "unit", "above", "maximum", "minimum")},
            {"kind": "float", "unit": "Hz", "above": None, "maximum": 10000.0, "minimum": 1e-6},
        )
        self.assertEqual(shown["waveform"]["kind"], "enum")
        self.assertIn("square", shown["waveform"]["choices"])
        self.assertIs(shown["autostart"]["value"], True)
        self.assertEqual(shown["seed"]["kind"], "int")
        self.assertTrue(shown["amplitude"]["help"])
        services = self.panels[NODE]["services"]
        self.assertIn({"name": NODE + "/enable", "kind": "SetBool"}, services)
        self.assertIn({"name": NODE + "/reset", "kind": "Trigger"}, services)
        self.assertNotIn("describe", str(services))

    def test_value_takes_effect_on_all_pages(self) -> None:
        one, other = self.panelled(), self.panelled()
        self.restore("amplitude")
        one.send("select", fields=["/signal/amplitude"])
        self.set(one, "amplitude", 3.25)
        for page in (one, other):
            page.wait_for(
                "value", lambda reply: (reply["name"], reply["value"]) == ("amplitude", 3.25)
            )
        self.assertEqual(rospy.get_param(NODE + "/amplitude"), 3.25)
        wait_until(lambda: 3.25 in one.values("/signal/amplitude"), lambda: one.bins)
        self.assertEqual(one.messages("refused"), [])

    def test_value_out_of_range_is_rejected_and_never_written(self) -> None:
        page = self.panelled()
        self.set(page, "rate", -1)
        refused = page.wait_for("refused")
        self.assertEqual((refused["node"], refused["name"], refused["value"]), (NODE, "rate", -1))
        self.assertIn("must be a number in [1e-06, 10000]", refused["text"])
        page.wait_for("value", lambda reply: (reply["name"], reply["value"]) == ("rate", 100.0))
        self.set(page, "waveform", "wavy")
        page.wait_for("refused", lambda reply: "one of sine, square" in reply["text"])
        self.set(page, "autostart", 1)
        page.wait_for("refused", lambda reply: "true or false" in reply["text"])

    def test_only_services_and_parameters_on_panels_can_be_used(self) -> None:
        page = self.panelled()
        requests = [
            ("call", {"service": "/signal_generator/set_logger_level"}),
            ("call", {"service": "/rosout/get_loggers"}),
            ("call", {"service": NODE + "/enable"}),
            ("set", {"node": NODE, "name": "undeclared", "value": 1}),
            ("set", {"node": "/", "name": "run_id", "value": 1}),
        ]
        for kind, content in requests:
            page.forget()
            page.send(kind, **content)
            page.wait_for("error")

    def test_the_graph_has_nodes_edges_and_rates(self) -> None:
        page = self.panelled()
        page.send("graph", on=True)
        expected = {"from": NODE, "to": "/process", "topic": "/signal"}

        def has_rate(graph: Any) -> bool:
            rates = [edge["rate"] for edge in graph["edges"] if expected.items() <= edge.items()]
            return len(rates) == 1 and rates[0] is not None and 80.0 < rates[0] < 120.0

        graph = page.wait_for("graph", has_rate)
        self.assertLessEqual({NODE, "/process"}, set(graph["nodes"]))
        self.assertIn({"name": "/signal", "datatype": "basic_comms/signal_msg"}, graph["topics"])
        own = "/scope_" + self.scope.url.rpartition(":")[2]
        self.assertIn(own, rosnode.get_node_names())
        self.assertNotIn(own, graph["nodes"])
        page.send("graph", on=False)
        page.send("foo")  # answered after that
        page.wait_for("error")
        page.forget()
        self.restore("phase")
        rospy.set_param(NODE + "/phase", 0.5)
        page.wait_for("value")
        self.assertEqual(page.messages("graph"), [])


class Guards(SignalsTest):
    """Access, and malformed requests."""

    def test_page_of_another_site_is_rejected(self) -> None:
        for headers in (
            {"Origin": "http://example.com"},
            {"Origin": self.scope.url + "0"},
            {"Origin": "null"},
            {"Origin": "http://rebound.example.com:80", "Host": "rebound.example.com:80"},
        ):
            with self.assertRaises(HTTPClientError) as caught:
                Client(self.scope.url, headers)
            self.assertEqual(caught.exception.code, 403, headers)
        self.page(headers={"Origin": self.scope.url})

    def test_foreign_host_names_are_rejected_everywhere(self) -> None:
        for path in ("/", "/static/index.html", "/dygraphs/dygraph.min.js", "/data.csv?field=/a/x"):
            self.assertEqual(fetch(self.scope.url + path)[0], 200, path)
            self.assertEqual(fetch(self.scope.url + path, {"Host": "example.com"})[0], 403, path)

    def test_page_has_strict_headers(self) -> None:
        connection = http.client.HTTPConnection(self.scope.url.partition("//")[2])
        self.addCleanup(connection.close)
        connection.request("GET", "/")
        answer = connection.getresponse()
        self.assertIn("frame-ancestors 'none'", answer.headers["Content-Security-Policy"])
        self.assertEqual(answer.headers["X-Content-Type-Options"], "nosniff")

    def test_nothing_outside_of_the_folders_is_served(self) -> None:
        for folder in ("/static/", "/dygraphs/", "/"):
            for way in (
                "../package.xml",
                "..%2fpackage.xml",
                "%2e%2e/package.xml",
                "/etc/passwd",
                "..\\package.xml",
                "js/../../package.xml",
                "../" * 12 + "etc/passwd",
            ):
                status, text = fetch(self.scope.url + folder + way)
                self.assertIn(status, (400, 403, 404), folder + way)
                self.assertNotIn("<package", text)
                self.assertNotIn("root:", text)

    def test_garbage_gets_an_error_and_the_page_stays(self) -> None:
        page = self.page()
        for text in (
            "",
            "{",
            "[]",
            "null",
            "\x00",
            b"\xff\x00",
            '{"type": "view"}',
            "[" * 60000,
            '{"type": "set", "node": 1}',
            '{"type": "view", "window": 1e999, "width": 5}',
        ):
            page.forget()
            page.send_text(text)
            page.wait_for("error")
            page.wait_for("frame")
        self.assertFalse(page.is_closed)

    def test_too_long_request_ends_only_its_page(self) -> None:
        page, other = self.page(), self.page()
        page.send_text("x" * 1000000)
        wait_until(lambda: page.is_closed, lambda: "it is still open")
        other.forget()
        other.wait_for("frame")


class ReadOnly(ScopeTest):
    """A scope that is open to the network."""

    ARGUMENTS = ["/signal/signal_y", "--address", "0.0.0.0"]

    def test_read_only_page_cannot_set_anything(self) -> None:
        page = self.page()
        self.assertTrue(page.wait_for("hello")["readonly"])
        page.wait_for("panels", lambda reply: "/signal_generator" in str(reply["panels"]))
        wait_until(lambda: page.values("/signal/signal_y"), lambda: page.bins)
        before = rospy.get_param("/signal_generator/amplitude")
        for request in (
            {"type": "set", "node": "/signal_generator", "name": "amplitude", "value": 7.0},
            {"type": "call", "service": "/signal_generator/enable", "data": False},
            {"type": "transition", "node": "/n", "label": "configure"},
            {"type": "steer", "topic": "/cmd_vel"},
            {"type": "drive", "speed": 0.1, "turn": 0, "sent": 0},
            {"type": "goal", "topic": "/goal", "frame": "odom", "x": 0, "y": 0, "heading": 0},
        ):
            page.forget()
            page.send_text(json.dumps(request))
            self.assertIn("read-only", page.wait_for("error")["text"])
        self.assertEqual(page.messages("called"), [])
        self.assertEqual(rospy.get_param("/signal_generator/amplitude"), before)


class DeadMan(RobotsTest):
    """A robot without commands stops: one zero, then silence."""

    #: End of the driving, and type of the robot's commands.
    ENDS: Dict[str, Tuple[Any, Callable[[Client], Any]]] = {
        # Likewise a cut or stalled link, of which the scope is not notified.
        "says nothing any more": (Twist, lambda page: None),
        "lets go": (
            Twist,
            lambda page: page.send("drive", speed=0, turn=0, sent=time.monotonic()),
        ),
        "closes": (TwistStamped, Client.close),
        "is gone without a word": (Twist, Client.cut),
        "looks at something else": (Twist, lambda page: page.send("robots", on=False)),
    }

    def test_robots_stop_in_time_after_any_end_of_driving(self) -> None:
        robots = {
            end: self.robot(f"/end{number}/", kind)
            for number, (end, (kind, _)) in enumerate(self.ENDS.items())
        }
        # Retried on a busy machine; a real delay fails each time.
        best = dict.fromkeys(robots, math.inf)
        for _ in range(ATTEMPTS):
            for end, late in self.driven(robots).items():
                best[end] = min(best[end], late)
            if max(best.values()) < STOPS_WITHIN_S:
                break
        self.assertLess(max(best.values()), STOPS_WITHIN_S, best)

    def driven(self, robots: Dict[str, Robot]) -> Dict[str, float]:
        """Drive robots, and return the time from the last command to the stop of each [s].

        It is infinite after an earlier pause, or if anything followed the single zero.
        """
        for robot in robots.values():
            robot.commands.clear()
        pages = {end: self.driver(f"/end{n}/cmd_vel") for n, end in enumerate(robots)}
        self.drive(*pages.values())
        for end, page in pages.items():
            self.ENDS[end][1](page)
        for robot in robots.values():
            self.stopped(robot)
        time.sleep(0.5)  # longer than any command counts
        took = {}
        for end, robot in robots.items():
            *moving, last = list(robot.commands)
            is_once = {reply[1:] for reply in moving} == {(0.2, 0.5)} and last[1:] == (0.0, 0.0)
            took[end] = last.when - moving[-1].when if is_once else math.inf
        return took


if __name__ == "__main__":
    rospy.init_node("test_scope")
    rosrun("topic_scope", "scope", "test_scope")
