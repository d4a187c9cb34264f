"""The highest rate at which a process node answers every message for ten seconds."""

import itertools
import subprocess
import time
from typing import List, Optional

from . import stacks
from .analysis import highest_passing
from .context import Bench, Figures
from .observers import Counter, wait_until

#: rates to try, messages per second: each a quarter above the one before
RATES: List[float] = [round(1000 * 1.25**step, -2) for step in range(32)]
#: A source that falls behind by more is being held up by the process, s.
LATEST = 0.1
#: how long answers may still come after the last message, as a share of the time it took to send
#: all, so that what a probe finds is near to what can be held
GRACE = 0.05
#: how long a rate is tried: in the search, before it is held, and held, s
PROBE_S, TRIAL_S, HOLD_S = 1.0, 3.0, 10.0

_numbers = itertools.count(1)


def zero_loss_rate(bench: Bench, stack: str) -> Figures:
    """Find the highest rate by short probes, then have it or a lower one held for ten seconds."""
    with _Source(bench, stack) as source:
        found = highest_passing(RATES, source.passes_probe)
        lower = [rate for rate in RATES if found is not None and rate <= found]
        hold = bench.seconds(HOLD_S, PROBE_S)
        for rate in reversed(lower):
            if source.passes(rate, min(TRIAL_S, hold)) and source.passes(rate, hold):
                return {"rate": rate}
    return {"rate": 0.0}


class _Source:
    """A source, a process and a counter behind it."""

    def __init__(self, bench: Bench, stack: str) -> None:
        self._bench = bench
        self._stack = stack
        self._group = f"/rate{next(_numbers)}"
        self._topic = self._group + "/proc_signal"

    def __enter__(self) -> "_Source":
        session = self._bench.session
        self._node_context = session.node()
        self._counter = Counter(self._node_context.__enter__())
        self._counter.watch(self._topic, stacks.output_type(self._stack))
        process = stacks.process_command(self._bench.peers, self._stack)
        self._process = session.start(process, session.in_group(self._group))
        self._source = session.start(
            stacks.peer(
                "burst_source.py", session.master_uri, self._group + "/signal", signal_msg_md5sum()
            ),
            talk=True,
        )
        return self

    def __exit__(self, *_error: object) -> None:
        session = self._bench.session
        session.stop(self._source)
        session.stop(self._process)
        self._node_context.__exit__(None, None, None)

    def passes_probe(self, rate: float) -> bool:
        """Tell whether a rate can be held for a moment; a failure may be chance, two are not."""
        return self.passes(rate, PROBE_S) or self.passes(rate, PROBE_S)

    def passes(self, rate: float, seconds: float) -> bool:
        """Tell whether every message is answered, and in time."""
        before = self._count()
        assert self._source.stdin is not None and self._source.stdout is not None
        self._source.stdin.write(b"%g %g\n" % (rate, seconds))
        self._source.stdin.flush()
        answer = self._source.stdout.readline().split()
        if not answer:  # it waits for nothing without end
            raise RuntimeError(f"the source has ended: {self._bench.session.log_of(self._source)}")
        expected = before + int(answer[0])
        give_up = time.monotonic() + GRACE * seconds
        while self._count() < expected and time.monotonic() < give_up:
            time.sleep(Counter.PERIOD)
        good = self._count() == expected and float(answer[1]) <= LATEST
        if not good:
            self._settle()
        return good

    def _count(self) -> int:
        return self._counter.counts()[self._topic]

    def _settle(self) -> None:
        """Wait until what is still queued has gone through."""
        last: Optional[int] = None

        def still() -> bool:
            nonlocal last
            before, last = last, self._count()
            time.sleep(0.1)
            return before == last

        wait_until(still, 60.0, "end of the queue")


def signal_msg_md5sum() -> str:
    """Return the checksum of basic_comms/signal_msg."""
    return subprocess.check_output(["rosmsg", "md5", "basic_comms/signal_msg"]).decode().strip()
