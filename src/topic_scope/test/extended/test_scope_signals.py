"""Samples sent to pages: signals of any type and time, and an overlaid bag."""

import math
import os
import tempfile
from typing import Any, Iterator

import genpy
import genpy.dynamic
import rosbag
import rospy
from browsing.scope_process import ScopeProcess
from geometry_msgs.msg import PointStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Float32, Float64, Float64MultiArray
from wire.client import Client
from wire.signals_test import SignalsTest

from nodekit.testing.waiting import wait_until


def sine(begin: genpy.Time, count: int, late: float) -> Iterator[PointStamped]:
    """Return messages of a sine of 1 Hz with a delay [s]; 100 per second."""
    for index in range(count):
        message = PointStamped()
        message.header.stamp = begin + genpy.Duration(index // 100, index % 100 * 10**7)
        message.point.x = math.sin(2.0 * math.pi * (0.01 * index - late))
        yield message


class Signals(SignalsTest):
    """Scope that records the course's signals."""

    def test_omitted_fields_of_a_topic_are_reported(self) -> None:
        publisher = rospy.Publisher("/wide", Odometry, queue_size=1)
        self.addCleanup(publisher.unregister)
        page = self.page()
        page.wait_for("fields", lambda reply: "/wide/pose" in str(reply))
        page.send("select", fields=["/wide"])
        self.assertEqual(
            page.wait_for("error")["text"],
            "a page shows at most 32 traces: the rest of 47 are left out",
        )
        self.assertEqual(len(page.wait_for("selected")["fields"]), 32)

    def test_non_finite_values_are_sent_as_null(self) -> None:
        page = self.page("/finite/data")
        publisher = self.publisher("/finite", Float64, page)
        self.publish(publisher, [math.nan, math.inf, -math.inf, 5.0])
        wait_until(lambda: page.values("/finite/data"), lambda: page.bins)
        self.assertEqual(set(page.values("/finite/data")), {5.0})
        cells = [row[0] for _, row in self.samples("/finite/data")]
        self.assertEqual(cells, ["nan", "inf", "-inf", "5.0"])

    def test_statistics_are_sent_less_often_than_frames(self) -> None:
        page = self.page()
        wait_until(lambda: len(page.messages("stats")) > 8, lambda: page.messages("frame")[-1:])
        heard = [message["heard"] for message in page.messages("stats")]
        self.assertGreater((heard[-1] - heard[0]) / (len(heard) - 1), 0.2)  # 0.25 s, and by rounds

    def test_fields_of_one_message_share_a_row(self) -> None:
        page = self.page()
        wait_until(lambda: len(page.values("/signal/signal_y")) > 50, lambda: page.bins)
        page.send("select", fields=["/signal/signal_y:time_x", "/proc_signal/data"])
        wait_until(lambda: len(page.values("/signal/time_x")) > 50, lambda: page.bins)
        rows = self.samples("/signal/signal_y", "/signal/time_x", "/proc_signal/data")
        both = [row for _, row in rows if row[1]]
        self.assertTrue(both)
        for level, moment, other in both:
            # The documented signal: 2 sin(2 pi t).
            expected = 2.0 * math.sin(2.0 * math.pi * float(moment))
            self.assertAlmostEqual(float(level), expected, delta=1e-5)
            self.assertEqual(other, "")
        self.assertEqual([moment for moment, _ in rows], sorted(moment for moment, _ in rows))

    def test_trace_uses_the_time_of_its_messages_or_a_selected_one(self) -> None:
        own, received = "/signal/signal_y", "/signal/signal_y@received"
        page = self.page(own, received, "/proc_signal/data")
        bases = {own: "time_x", received: "received", "/proc_signal/data": "received"}
        page.wait_for(
            "stats",
            lambda stats: (
                {name: trace.get("timestamp") for name, trace in stats["traces"].items()} == bases
            ),
        )
        wait_until(lambda: len(self.samples(received)) > 150, lambda: "no samples")
        rows = self.samples(own, "/signal/time_x")
        ends = [(moment, float(cells[1])) for moment, cells in rows if all(cells)]
        # The trace's times are the stamps of the messages, to the microsecond.
        for (moment, time_x), (later, later_x) in zip(ends, ends[1:]):
            self.assertAlmostEqual(later - moment, later_x - time_x, delta=2e-6)
        page.send("select", fields=["/signal/signal_y@stamp"])
        text = page.wait_for("error")["text"]
        self.assertIn("there is no time header/stamp in basic_comms/signal_msg", text)

    def test_bag_is_overlaid_on_the_graph_and_aligned_at_the_trigger(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = os.path.join(folder.name, "old.bag")
        with rosbag.Bag(path, "w") as bag:
            for message in sine(genpy.Time(10**9), 400, 0.23):
                bag.write("exact", message, message.header.stamp)
        scope = ScopeProcess("--over", path)
        self.addCleanup(scope.stop)
        scope.wait_until_served()
        page = Client(scope.url)
        self.addCleanup(page.close)
        live, old = "/exact/point/x@stamp", "/old/exact/point/x@stamp"
        apart = f"={live} - {old}"
        page.wait_for("hello")
        page.send("select", fields=[live, old, apart])
        publisher = self.publisher("/exact", PointStamped, page)
        page.send("trigger", mode="single", number=1, field=live, level=0.5, edge="rising")
        page.wait_for("trigger", lambda reply: reply["number"] == 1)
        for message in sine(rospy.Time.now() + rospy.Duration(0.5), 300, 0.0):
            publisher.publish(message)
        at = page.wait_for("trigger", lambda reply: reply["time"] is not None)["time"]
        # A period earlier it would be the same sine, and begins earlier.
        page.send("overlay", name="old", trigger=at, offset=-1.0)
        page.send("view", window=1.0, width=500, end=at + 1.0)

        def difference(reply: Any) -> float:
            measured = reply["traces"].get(apart, {})
            return float(measured["rms"]) if measured.get("max") is not None else math.inf

        # A tenth of a sample.
        page.wait_for("stats", lambda reply: difference(reply) < 0.0044)

    def test_a_type_that_is_not_installed(self) -> None:
        text = "string name\nfloat64[] levels\nInner[2] inner\n" + "=" * 80
        text += "\nMSG: nowhere/Inner\ntime stamp\nbool on\n"
        classes = genpy.dynamic.generate_dynamic("nowhere/Outer", text)
        publisher = rospy.Publisher("/nowhere", classes["nowhere/Outer"], queue_size=10, latch=True)
        self.addCleanup(publisher.unregister)
        message = classes["nowhere/Outer"](name="x", levels=[1.5, 2.5])
        message.inner = [classes["nowhere/Inner"](stamp=rospy.Time(7, 5), on=on) for on in (0, 1)]
        publisher.publish(message)
        page = self.page()
        listed = page.wait_for("fields", lambda fields: "nowhere/levels" in str(fields))["fields"]
        names = [choice["field"] for choice in listed if choice["field"].startswith("/nowhere/")]
        self.assertEqual(
            names,
            ["/nowhere/levels[0]", "/nowhere/levels[1]"]
            + [f"/nowhere/inner[{n}]/{name}" for n in (0, 1) for name in ("stamp", "on")]
            + ["/nowhere/name.state"],
        )
        page.send("select", fields=["/nowhere/levels[1]", "/nowhere/inner[1]/on"])
        selected = ["/nowhere/levels[1]", "/nowhere/inner[1]/on"]
        page.wait_for("frame", lambda frame: list(frame["traces"]) == selected)

        def arrived() -> bool:
            publisher.publish(message)
            return 2.5 in page.values(selected[0]) and 1.0 in page.values(selected[1])

        wait_until(arrived, lambda: page.bins)

    def test_a_topic_that_appears_later_and_changes_its_type(self) -> None:
        page = self.page("/changing", "/changing/missing")
        publisher = self.publisher("/changing", Float32, page)
        wait_until(
            lambda: publisher.publish(3.0) or 3.0 in page.values("/changing/data"),
            lambda: page.bins,
        )
        publisher.unregister()
        publisher = self.publisher("/changing", Float64MultiArray, page)
        page.send("select", fields=["/changing/data[1]"])
        message = Float64MultiArray(data=[4.0, 5.0])
        wait_until(
            lambda: publisher.publish(message) or 5.0 in page.values("/changing/data[1]"),
            lambda: page.bins,
        )

    def test_missing_field_is_reported(self) -> None:
        page = self.page("/signal/nothing")
        self.assertIn("no nothing in", page.wait_for("error")["text"])
