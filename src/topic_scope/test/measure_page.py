#!/usr/bin/env python3
"""Measure how fast the page of the oscilloscope is: 10 traces at 1 kHz, 5 s of them in view.

    ./ci/exec src/topic_scope/test/measure_page.py

It prints the frames a second that Chromium without a screen draws, the time from publish() to the
pixel, and the scope's CPU time and memory. The first trace carries the time at which
it was published. A frame is visible at the second animation frame after its arrival: the first
draws it, and the second starts after it was presented.
"""

import multiprocessing
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import List

import numpy
import rosgraph
from browsing.browser import Browser
from browsing.scope_process import ScopeProcess
from browsing.waiting import wait_until

from nodekit.testing.processes import free_port

TRACES, RATE_HZ = 10, 1000.0
SETTLE_S, MEASURE_S = 7.0, 20.0
TOPICS = [f"/rig/s{number}" for number in range(TRACES)]

#: Records for each frame the age of its newest sample at arrival and at display, and the time of
#: drawing [ms].
WATCH = """
const Socket = WebSocket;
window.WebSocket = class extends Socket {
  constructor(url) {
    super(url);
    window.ages = [];
    this.addEventListener("message", (event) => {
      const message = JSON.parse(event.data);
      const newest = message.type === "frame" && message.traces["/rig/s0/data"].at(-1);
      if (!newest) return;
      const age = () => Date.now() - newest * 1000;
      const arrived = age();
      requestAnimationFrame((drawn) =>
        requestAnimationFrame(() => window.ages.push([arrived, age(), drawn])));
    });
  }
};
"""


def publish() -> None:
    """Publish all topics at their rate, without drift, in a separate process."""
    import rospy
    from std_msgs.msg import Float64

    rospy.init_node("rig")
    publishers = [
        rospy.Publisher(topic, Float64, queue_size=None, tcp_nodelay=True) for topic in TOPICS
    ]
    start, count = time.time(), 0
    while not rospy.is_shutdown():
        count += 1
        time.sleep(max(0.0, start + count / RATE_HZ - time.time()))
        now = time.time()
        for number, publisher in enumerate(publishers):
            publisher.publish(now if number == 0 else number + numpy.sin(6.0 * now + number))


def processor_time(pid: int) -> float:
    """Return the CPU time of a process [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb(pid: int) -> float:
    """Return the resident memory of a process, MB."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1000.0 for line in lines if line.startswith("VmRSS"))


def report(browser: Browser, pid: int) -> None:
    """Measure and print."""
    time.sleep(SETTLE_S)
    browser.run("window.ages = []")
    begin, used = time.monotonic(), processor_time(pid)
    time.sleep(MEASURE_S)
    ages: List[List[float]] = browser.run("return window.ages")
    seconds = time.monotonic() - begin
    share = (processor_time(pid) - used) / seconds
    arrived, seen, drawn = numpy.transpose(ages)
    print(f"frames a second:            {len(set(drawn)) / seconds:5.1f}")
    print("publish to page, ms:        %5.1f median, %5.1f p95" % _middle_and_high(arrived))
    print("publish to pixel, ms:       %5.1f median, %5.1f p95" % _middle_and_high(seen))
    print(f"processor of the scope:     {100.0 * share:5.0f} % of a core")
    print(f"memory of the scope:        {memory_mb(pid):5.0f} MB")


def _middle_and_high(values: "numpy.ndarray[numpy.float64]") -> "tuple[float, float]":
    return float(numpy.median(values)), float(numpy.percentile(values, 95))


def main() -> None:
    """Run everything on a master of its own."""
    port = free_port()
    os.environ["ROS_MASTER_URI"] = f"http://localhost:{port}"
    master = subprocess.Popen(["roscore", "-p", str(port)], stdout=sys.stderr)
    wait_until(rosgraph.is_master_online, lambda: "no master")
    rig = multiprocessing.Process(target=publish)
    rig.start()
    scope = ScopeProcess(*[topic + "/data" for topic in TOPICS], "--window", "5")
    browser = Browser()
    try:
        browser.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WATCH})
        scope.wait_until_served()
        browser.open(scope.url)
        report(browser, scope.pid)
    finally:
        browser.close()
        scope.stop()
        rig.terminate()
        rig.join()
        master.terminate()
        master.wait()


if __name__ == "__main__":
    main()
