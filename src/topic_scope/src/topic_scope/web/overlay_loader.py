"""Loader of overlaid bags: reads them outside the web thread, and shifts them in time."""

import os
from typing import Any, Callable, Dict, List, Sequence, Tuple

import numpy
import rospy

from topic_scope.bag.series import Series
from topic_scope.bag.overlay import BagOverlay
from topic_scope.graph.worker import Worker
from topic_scope.page.open_page import Page
from topic_scope.page.trigger import crossings
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.options import Options
from topic_scope.protocol.overlay_request import OverlayRequest
from topic_scope.protocol.requests import Trigger
from topic_scope.sampling.overlay_trace import OverlayTrace


def open_overlays(options: Options) -> List[BagOverlay]:
    """Open the bags that a command line names.

    :raises BagError: if a bag cannot be read
    """
    bags = [BagOverlay(one.path, one.name, one.offset) for one in options.over]
    for bag in bags:
        for topic, text in bag.faults.items():
            rospy.logwarn(f"{bag.path}: {topic} is left out: {text}")
    return bags


class OverlayLoader:
    """Loader of the requested traces of bags, and of their shifts; shared by all pages.

    All methods are for the web thread.

    :param bags: the bags
    :param deliver: runs a function in the web thread
    :param on_change: called after traces were loaded or shifted
    """

    def __init__(
        self,
        bags: Sequence[BagOverlay],
        deliver: Callable[[Callable[[], None]], None],
        on_change: Callable[[], None],
    ) -> None:
        self._bags = {bag.name: bag for bag in bags}
        self._worker = Worker(deliver)
        self._on_change = on_change

    @property
    def types(self) -> Dict[str, str]:
        """Types of their topics."""
        return {topic: kind for bag in self._bags.values() for topic, kind in bag.types.items()}

    def begin_at(self, time: float) -> None:
        """Set the start of all bags by the scope's clock [s]."""
        for bag in self._bags.values():
            bag.begin = time

    def message(self) -> Dict[str, Any]:
        """Return the message that describes the bags to a page."""
        bags = [
            {
                "name": bag.name,
                "file": os.path.basename(bag.path),
                "begin": bag.begin,
                "offset": bag.offset,
                "length": bag.length,
            }
            for bag in self._bags.values()
        ]
        return {"type": "overlays", "bags": bags}

    def read_wanted(self) -> None:
        """Start reading the traces without samples; a busy bag is read again later."""
        for bag in self._bags.values():
            self._read(bag)

    def _read(self, bag: BagOverlay) -> None:
        if self._worker.is_busy(bag.name):
            return
        wanted = bag.take_wanted()
        if wanted:
            names = [name for name, _ in wanted]
            self._worker.run(
                bag.name, lambda: bag.read(names), lambda found: self._fill(bag, wanted, found)
            )

    def _fill(
        self, bag: BagOverlay, wanted: Sequence[Tuple[str, OverlayTrace]], found: Any
    ) -> None:
        if isinstance(found, Exception):
            rospy.logwarn(f"{bag.name}: {found}")
            for _, trace in wanted:
                trace.problem = str(found)
        else:
            series: Dict[str, Series] = {one.name: one for one in found}
            for name, trace in wanted:
                one = series[name]
                times, values = numpy.array(one.times), numpy.array(one.values)
                trace.fill(times, values, one.correction, one.states)
        self._on_change()
        self._read(bag)

    def lay(self, page: Page, wanted: OverlayRequest) -> None:
        """Shift a bag.

        :raises RequestError: if there is no such bag, or no trigger to align it with
        """
        bag = self._bags.get(wanted.name)
        if bag is None:
            known = ", ".join(self._bags) or "none: name bags by the scope's option --over"
            raise RequestError(f"overlay: no bag {wanted.name}; there are {known}")
        if wanted.trigger is not None:
            self._align(bag, page, wanted.trigger)
        if wanted.offset is not None:
            bag.offset = wanted.offset
        if wanted.begin is not None:
            bag.begin = wanted.begin
        self._on_change()

    def _align(self, bag: BagOverlay, page: Page, time: float) -> None:
        """Shift a bag so that its first crossing is at a time, as soon as it is read."""
        trigger = page.trigger.request
        if trigger.mode == "off":
            raise RequestError("overlay: no trigger to align a bag with")
        name = bag.name_in_bag(trigger.field)

        def move(found: Any) -> None:
            if isinstance(found, Exception):
                page.put_once({"type": "error", "text": f"{bag.name}: {found}"})
                return
            moments = _crossings(found[0], page, trigger, bag.longest_step(found[0]))
            if not len(moments):
                way = "rises" if trigger.rising else "falls"
                text = f"{bag.name}: {name} never {way} through {trigger.level:g}"
                page.put_once({"type": "error", "text": text})
                return
            bag.begin = time - float(moments[0])
            self._on_change()

        if not self._worker.run((bag.name, "align"), lambda: bag.read([name]), move):
            raise RequestError(f"overlay: {bag.name} is being aligned already")


def _crossings(series: Series, page: Page, trigger: Trigger, longest: float) -> numpy.ndarray:
    """Return the times at which a trace of a bag, scaled as on the page, meets the trigger [s]."""
    samples = numpy.array(series.times), numpy.array(series.values)
    times, values = page.scaling.scaled(lambda *_: samples)(trigger.field, 0.0, 0.0)
    longest = 0.0 if page.scaling.is_stepped(trigger.field) else longest
    return crossings(times, values, trigger.level, trigger.rising, trigger.hysteresis, longest)
