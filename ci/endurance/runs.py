"""All runs there are."""

from typing import Callable, List, NamedTuple

import run_bridge
import run_crowd
import run_interrupt
import run_managed
import run_record
import run_respawn
import run_scope
import run_stalled
from checks import Check
from surroundings import Soak


class Run(NamedTuple):
    """One way to wear the nodes out."""

    name: str
    help: str
    run: Callable[[Soak], List[Check]]


RUNS = [
    Run("record", "a signal of 1 kHz, its answers and a bag", run_record.run),
    Run("respawn", "kill -9 of each node, which is started again", run_respawn.run),
    Run("stalled", "a subscriber at 1 kHz that is stopped for a minute", run_stalled.run),
    Run("interrupt", "Ctrl-C at a random moment of a node's life", run_interrupt.run),
    Run("managed", "kill -9 and stops of managed nodes under their manager", run_managed.run),
    Run("scope", "ten traces of 1 kHz on the page of the oscilloscope", run_scope.run),
    Run("bridge", "1 kHz through the bridge, then kill -9 of it and of each side", run_bridge.run),
    Run("crowd", "20 subscribers that come and go", run_crowd.run),
]
