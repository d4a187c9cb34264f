"""Time series of the fields and formulas that names select in a bag, without unreadable topics."""

from typing import Dict, Iterable, List, Mapping, Optional, Sequence, Tuple

from topic_scope.bag.columns import Line, choose_lines
from topic_scope.bag.recording import Recording
from topic_scope.bag.message_slices import FirstMessage, Slice
from topic_scope.bag.series import Series, collect, computed
from topic_scope.bag.column_reader import ColumnReader
from topic_scope.formulas.names import expand, terms
from topic_scope.messages.fields import FieldError, parted, split


def chosen(
    bag: Recording, first: Mapping[str, FirstMessage], names: Sequence[str]
) -> Tuple[List[Line], List[ColumnReader]]:
    """Return the lines that names denote in a bag, and the readers of their columns.

    Lines of unreadable topics are left out and added to ``left_out`` of the bag.

    :param bag: the bag
    :param first: as :func:`.first_messages` returns them
    :param names: names of fields, or formulas
    :raises FieldError: if a field does not exist, a formula is invalid, or no line is left
    """
    lines: Dict[str, Line] = {}
    for name in names:
        fault = _fault(name, bag, first)
        if fault is None:
            lines.update((line.name, line) for line in choose_lines([name], first))
        else:
            bag.left_out.append(fault)
    if bag.left_out and not lines:
        raise FieldError("; ".join(dict.fromkeys(bag.left_out)))
    columns = dict.fromkeys(column for line in lines.values() for column in line.columns)
    readers = [ColumnReader(column, first[column.topic], bag.start) for column in columns]
    return list(lines.values()), readers


def _fault(name: str, bag: Recording, first: Mapping[str, FirstMessage]) -> Optional[str]:
    """Return why a line cannot be read; None if all of its topics are readable."""
    topics = {*first, *bag.faults}
    for field in (parted(term)[0] for one in expand(name) for term in terms(one)):
        place = split(field, topics)
        if place is not None and place[0] in bag.faults:
            return f"{bag.path}: {place[0]} is left out: {bag.faults[place[0]]}"
    return None


def series_of(
    bag: Recording,
    lines: Sequence[Line],
    readers: List[ColumnReader],
    messages: Iterable[List[Slice]],
) -> List[Series]:
    """Return lines over time.

    :param bag: the bag
    :param lines: as :func:`chosen` returns them
    :param readers: the same
    :param messages: messages of their topics
    """
    found = collect(readers, messages)
    if bag.lost:
        found = [one._replace(correction=_with_lost(one.correction, bag)) for one in found]
    series = {one.name: one for one in found}
    return [
        computed(line.name, line.formula, found) if line.formula else series[line.name]
        for line in lines
    ]


def _with_lost(correction: Optional[str], bag: Recording) -> str:
    text = f"{len(bag.lost)} damaged part{'s' * (len(bag.lost) > 1)} of the bag left out"
    return "; ".join(filter(None, (correction, text)))
