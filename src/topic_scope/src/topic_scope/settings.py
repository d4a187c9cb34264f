"""Set parameters of nodes, and find out what the nodes make of it.

A value is written to the parameter server, as ``rosparam set`` does. Whether it has come into force
is for the node to say: its description is asked for until it holds the value, or until the node has
warned of it, or for some time.
"""

import time
from functools import partial
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Set, Tuple

from nodekit.parameters.kinds import ParameterError, to_wire
from topic_scope.background import Background
from topic_scope.panels import DescriptionError, Panel, refusal_in, values_in

#: How long after a value it is asked whether it has come into force, and how long the node may
#: take, s.
CONFIRM_S, PATIENCE_S = 0.15, 2.0

#: Tells one page.
Answer = Callable[[Dict[str, Any]], None]


class Asked(NamedTuple):
    """A value that a page has set, and that the node has not confirmed yet.

    :param panel: the node's panel
    :param value: the value
    :param since: when it was set, s on the monotonic clock
    :param answer: tells the page
    """

    panel: Panel
    value: Any
    since: float
    answer: Answer


class Settings:
    """Sets values; all methods belong to the thread of the web.

    :param background: where to wait for the master and for nodes
    :param later: hands a function to the thread after some seconds
    :param write: writes values to the parameter server, by global name
    :param describe: returns the description of a node
    :param warnings: returns what nodes have warned of since a time
    :param tell: tells all pages of parameters that have changed
    """

    def __init__(
        self,
        background: Background,
        later: Callable[[float, Callable[[], None]], Any],
        write: Callable[[Mapping[str, Any]], None],
        describe: Callable[[str], str],
        warnings: Callable[[float], List[str]],
        tell: Callable[[Panel, List[str]], None],
    ) -> None:
        self._background, self._later = background, later
        self._write, self._describe = write, describe
        self._warnings, self._tell = warnings, tell
        self._asked: Dict[Tuple[str, str], Asked] = {}
        self._waiting: Dict[Tuple[str, str], Any] = {}
        self._confirming: Set[str] = set()

    def set(self, panel: Panel, name: str, value: Any, answer: Answer) -> None:
        """Set a parameter; the page is told if the value is refused.

        :param panel: the panel that it is on
        :param name: its name
        :param value: as the page has it
        :param answer: tells the page
        """
        try:
            judged = panel.judge(name, value)
        except ParameterError as error:
            _refuse(panel, name, value, str(error), answer)
            return
        self._asked[panel.node, name] = Asked(panel, judged, time.monotonic(), answer)
        self._waiting[panel.node, name] = to_wire(judged)
        self._write_waiting()

    def _write_waiting(self) -> None:
        """Write what is waiting, all at once; what comes meanwhile is written after that."""
        values = dict(self._waiting)
        writes = {"%s/%s" % place: value for place, value in values.items()}
        if values and self._background.run(
            "write", partial(self._write, writes), partial(self._on_written, values)
        ):
            self._waiting.clear()

    def _on_written(self, values: Mapping[Tuple[str, str], Any], result: Any) -> None:
        self._write_waiting()
        for (node, name), value in values.items():
            asked = self._asked.get((node, name))
            if asked is None:
                continue
            if isinstance(result, Exception):
                self._end(name, asked, "the master does not answer: nothing is set")
                continue
            self._tell(asked.panel, asked.panel.follow({name: value}))
            if node not in self._confirming:
                self._confirming.add(node)
                self._later(CONFIRM_S, partial(self._confirm, node))

    def _confirm(self, node: str) -> None:
        """Ask the node about its values, unless newer ones keep coming."""
        now = time.monotonic()
        asked = {name: ask for (of, name), ask in self._asked.items() if of == node}
        for name, ask in list(asked.items()):
            if now > ask.since + 2 * PATIENCE_S:
                self._end(name, asked.pop(name), "%s does not answer" % node)
        if not asked:
            self._confirming.discard(node)
            return
        if now >= max(ask.since for ask in asked.values()) + CONFIRM_S:
            judge = partial(self._on_described, asked)
            self._background.run(("describe", node), partial(self._describe, node), judge)
        self._later(CONFIRM_S, partial(self._confirm, node))

    def _on_described(self, asked: Mapping[str, Asked], text: Any) -> None:
        try:
            values = values_in(text) if isinstance(text, str) else {}
        except DescriptionError:
            values = {}
        for name, ask in asked.items():
            if name in values and self._asked.get((ask.panel.node, name)) is ask:
                self._settle(name, ask, values[name])

    def _settle(self, name: str, asked: Asked, in_force: Any) -> None:
        panel = asked.panel
        if panel.judge(name, in_force) == asked.value:
            del self._asked[panel.node, name]
            return
        said = refusal_in(self._warnings(asked.since), panel.node, name)
        if said is None and time.monotonic() > asked.since + PATIENCE_S:
            said = "%s has not taken this value" % panel.node
        if said is not None:
            self._tell(panel, panel.follow({name: in_force}))
            self._end(name, asked, said)

    def _end(self, name: str, asked: Asked, text: str) -> None:
        self._asked.pop((asked.panel.node, name), None)
        _refuse(asked.panel, name, asked.value, text, asked.answer)


def value_message(panel: Panel, name: str) -> Dict[str, Any]:
    """Return the message that tells a parameter's value."""
    return {"type": "value", "node": panel.node, "name": name, "value": panel.shown_value(name)}


def _refuse(panel: Panel, name: str, value: Any, text: str, answer: Answer) -> None:
    refused = {"type": "refused", "node": panel.node, "name": name, "value": to_wire(value)}
    answer({**refused, "text": text})
    answer(value_message(panel, name))
