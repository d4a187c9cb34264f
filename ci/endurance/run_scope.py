"""Watch ten traces of 1 kHz on the scope's page, for long: neither it nor the page may grow."""

import contextlib
import signal
import subprocess
import sys
import time
import urllib.request
from statistics import median
from typing import Any, Callable, List, NamedTuple, Tuple

from nodekit.testing.processes import free_port

from ..benchmark.cost import cpu_time
from ..benchmark.observers import wait_until
from ..benchmark.peer_programs import WORKSPACE
from .checks import Check, at_least, at_most, reported
from .surroundings import Soak
from .usage import Sampler, added

TESTS = WORKSPACE / "src" / "topic_scope" / "test"
RIG = [sys.executable, str(TESTS / "measure_load.py"), "--publish"]
FIELDS = [f"/load{number}/data" for number in range(10)]
#: samples that are kept, s: so that many are forgotten, too
HISTORY = 10.0
#: until the buffers of these have their size, s
WARM_UP = 120.0
#: How long the scope is kept from working once in that time, s. What piles up then takes another
#: piece of Python's memory, which is 1 MB; whenever the machine stalls next, there is room for it.
STALL = 2.0
#: how often the page is looked at, and how often at least a second it draws
LOOKS, FRAMES = 30, 1.0
#: how often one reading cleans up: the page goes on meanwhile, and the least counts
TRIES = 5
#: what the scope may take, MB
MEMORY = 120.0
#: by how much they may grow, %: what was drawn last is in the page
GROWTH, PAGE_GROWTH = 1.0, 5.0


class PageState(NamedTuple):
    """What the page holds at a moment, when all that it needs no more is gone."""

    #: JavaScript's objects, bytes
    heap: int
    elements: int
    listeners: int
    #: frames drawn in the second before
    frames: int


def run(soak: Soak) -> List[Check]:
    """Have a browser show the traces for as long as was asked for."""
    from browsing.browser import Browser  # Selenium, which no other run needs

    session = soak.session
    rig = session.start(RIG)
    session.wait_for("/load")
    port = free_port()
    command = [str(WORKSPACE / "devel" / "lib" / "topic_scope" / "scope.py"), *FIELDS]
    scope = session.start([*command, "--port", str(port), "--history", f"{HISTORY:g}"])
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
    seen = sampler.samples["scope"]
    memory = [one.memory for one in seen]
    return [
        reported("processor of the scope", f"{share:.0f} % of a core"),
        at_most("its memory at most", round(max(memory) / 1000.0, 1), MEMORY, "MB"),
        reported(
            "in tenths of the time", ", ".join(f"{one / 1000.0:.1f}" for one in tenths(memory))
        ),
        at_most("growth of its memory", growth(memory), GROWTH, "%"),
        at_most("its new threads", added([one.threads for one in seen]), 0),
        at_most("its new descriptors", added([one.descriptors for one in seen]), 0),
        at_least("traces with samples in the end", len(rates), len(FIELDS)),
        reported("their rates", ", ".join(sorted(set(rates)))),
        at_least("least frames a second", min(one.frames for one in states), FRAMES),
        reported("heap of the page, MB", ", ".join(f"{one.heap / 1e6:.1f}" for one in states)),
        *(
            at_most(f"growth of {name}", growth(values, min), PAGE_GROWTH, "%")
            for name, values in (
                ("the heap", [one.heap for one in states]),
                ("the page's elements", [one.elements for one in states]),
                ("its listeners", [one.listeners for one in states]),
            )
        ),
    ]


def warm_up(scope: "subprocess.Popen[bytes]") -> None:
    """Wait until the scope has taken the memory that it needs."""
    time.sleep(WARM_UP / 2.0)
    scope.send_signal(signal.SIGSTOP)
    try:
        time.sleep(STALL)
    finally:
        scope.send_signal(signal.SIGCONT)
    time.sleep(WARM_UP / 2.0)


def read_page(browser: Any) -> PageState:
    """Return what the page holds now."""
    driver = browser.driver
    frames = int(browser.text("#foot-frames").split()[0])
    seen: List[Tuple[int, int, int]] = []
    for _ in range(TRIES):
        driver.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
        heap = driver.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"]
        counts = driver.execute_cdp_cmd("Memory.getDOMCounters", {})
        seen.append((int(heap), counts["nodes"], counts["jsEventListeners"]))
    heaps, elements, listeners = zip(*seen)
    return PageState(min(heaps), min(elements), min(listeners), frames)


def growth(values: List[int], typical: Callable[[List[int]], float] = median) -> float:
    """Return by how much the last third of a series lies above the first one, %.

    Buffers fill up and begin anew, so a third is some of their periods.

    :param values: the series
    :param typical: what is compared; the least, where there is rubbish in each value
    """
    third = max(1, len(values) // 3)
    return round(100.0 * (typical(values[-third:]) / typical(values[:third]) - 1.0), 2)


def tenths(values: List[int]) -> List[float]:
    """Return the medians of ten parts of a series: they show growth from a step."""
    count = len(values)
    return [median(values[count * n // 10 : count * (n + 1) // 10] or values) for n in range(10)]


def is_served(url: str) -> bool:
    """Tell whether the page can be loaded."""
    with contextlib.suppress(OSError), urllib.request.urlopen(url) as answer:
        return bool(answer.status == 200)
    time.sleep(0.1)
    return False
