"""Watch ten traces of 1 kHz on the scope's page for long: neither process may grow."""

import contextlib
import signal
import subprocess
import sys
import time
import urllib.request
from typing import Any, List

import numpy as np

from nodekit.testing.processes import free_port

from ..benchmark.cost import cpu_time
from ..benchmark.peer_programs import WORKSPACE, executable
from ..benchmark.recorder import wait_until
from .checks import Check, at_least, at_most, reported
from .context import Soak
from .usage import Sampler, added, growth

RIG = WORKSPACE / "src" / "topic_scope" / "test" / "measure_load.py"
FIELDS = [f"/load{number}/data" for number in range(10)]
#: How long samples are kept [s]: short, so that many are dropped.
HISTORY = 10.0
#: Time until their buffers have their final size [s].
WARM_UP = 120.0
#: How long the scope is stopped once in that time [s]: the backlog makes Python allocate another
#: 1 MB arena, which later stalls of the machine then use.
STALL = 2.0
#: Number of reads of the page, and smallest allowed frame rate [1/s].
LOOKS, FRAMES = 30, 1.0
#: Number of garbage collections per read: the page runs meanwhile, and the smallest value counts.
TRIES = 5
#: Values read from the page: size of JavaScript's objects [bytes], and counts.
PARTS = ("heap", "elements", "listeners")
#: Most memory of the scope [MB].
MEMORY = 120.0
#: Highest growth of the scope and of the page [%]: the page holds the last drawing.
GROWTH, PAGE_GROWTH = 1.0, 5.0
#: Number of compared parts of a series: buffers fill up and restart several times in each.
THIRDS = 3


def run(soak: Soak) -> List[Check]:
    """Show the traces in a browser for the given time."""
    from browsing.browser import Browser  # Selenium, which no other run needs

    session = soak.session
    rig = session.start([sys.executable, str(RIG), "--publish"])
    session.wait_for("/load")
    port = free_port()
    options = ["--port", str(port), "--history", f"{HISTORY:g}"]
    scope = session.start(executable("topic_scope", "scope.py", *FIELDS, *options))
    url = f"http://localhost:{port}"
    wait_until(lambda: is_served(url), 30.0, "page of the scope")
    browser = Browser()
    states = []
    try:
        browser.open(url)
        warm_up(scope)
        began, used = time.monotonic(), cpu_time([scope.pid])
        with Sampler({"scope": scope.pid}) as sampler:
            for number in range(1, LOOKS + 1):
                time.sleep(max(0.0, began + soak.seconds * number / LOOKS - time.monotonic()))
                states.append(read_page(browser))
        share = 100.0 * (cpu_time([scope.pid]) - used) / (time.monotonic() - began)
        rates = browser.text("#legend [data-cell=rate]").split()
    finally:
        browser.close()
        session.stop(scope, rig)
    kilobytes, threads, descriptors = zip(*sampler.samples["scope"])
    memory = [one / 1000.0 for one in kilobytes]
    tenths = [f"{np.median(part):.1f}" for part in np.array_split(memory, 10) if len(part)]
    *parts, frames = zip(*states)
    return [
        reported("processor of the scope", f"{share:.0f} % of a core"),
        at_most("its memory at most", round(max(memory), 1), MEMORY, "MB"),
        reported("in tenths of the time", ", ".join(tenths)),
        at_most("growth of its memory", growth(memory, parts=THIRDS), GROWTH, "%"),
        at_most("its new threads", added(threads), 0),
        at_most("its new descriptors", added(descriptors), 0),
        at_least("traces with samples in the end", len(rates), len(FIELDS)),
        reported("their rates", ", ".join(sorted(set(rates)))),
        at_least("least frames a second", min(frames), FRAMES),
        reported("heap of the page, MB", ", ".join(f"{one / 1e6:.1f}" for one in parts[0])),
        *(
            # The smallest value counts, because each includes garbage.
            at_most(
                f"growth of the page's {name}", growth(values, np.min, THIRDS), PAGE_GROWTH, "%"
            )
            for name, values in zip(PARTS, parts)
        ),
    ]


def warm_up(scope: "subprocess.Popen[bytes]") -> None:
    """Wait until the scope has allocated its memory."""
    time.sleep(WARM_UP / 2.0)
    scope.send_signal(signal.SIGSTOP)
    try:
        time.sleep(STALL)
    finally:
        scope.send_signal(signal.SIGCONT)
    time.sleep(WARM_UP / 2.0)


def read_page(browser: Any) -> List[int]:
    """Return the PARTS of the page without garbage, and the frames drawn in the second before."""
    driver, seen = browser.driver, []
    frames = int(browser.text("#foot-frames").split()[0])
    for _ in range(TRIES):
        driver.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
        heap = driver.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"]
        counts = driver.execute_cdp_cmd("Memory.getDOMCounters", {})
        seen.append((int(heap), counts["nodes"], counts["jsEventListeners"]))
    return [*(min(values) for values in zip(*seen)), frames]


def is_served(url: str) -> bool:
    """Return whether the page can be loaded."""
    with contextlib.suppress(OSError), urllib.request.urlopen(url) as answer:
        return bool(answer.status == 200)
    return False
